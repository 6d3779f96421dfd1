"""Output files are whole or as they were before, whatever stops the process that writes them."""

import os
from contextlib import nullcontext
from pathlib import Path

import pytest
from refusals import refuses

from ehl.common.errors import InputError
from ehl.common.files import replacing, write_file


def test_a_file_is_replaced_only_when_it_is_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "result.json"
    write_file(path, "before")

    def stopped() -> None:
        with replacing(path) as draft:
            draft.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()

    def no_space(descriptor: int) -> None:
        raise OSError("No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", no_space)
        with pytest.raises(InputError) as refused:
            write_file(path, "after", "output")
    assert refused.value.field == "output"
    assert path.read_text() == "before"
    assert os.listdir(tmp_path) == ["result.json"]


def test_links_modes_and_folders_stay(tmp_path: Path) -> None:
    path, link = tmp_path / "new" / "result.json", tmp_path / "link"
    write_file(path, b"one")
    path.chmod(0o640)
    link.symlink_to(path)
    write_file(link, "two")
    assert link.is_symlink()
    assert path.read_text() == "two"
    assert path.stat().st_mode & 0o777 == 0o640
    write_file(Path(os.devnull), "nothing")
    with pytest.raises(InputError):
        write_file(tmp_path, "a folder")


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give links to others")
@pytest.mark.parametrize("kind", ["file", "folder"])
def test_links_that_others_planted_are_not_followed(kind: str, tmp_path: Path) -> None:
    """In a folder open to all, such as /tmp; Linux refuses to open them, but a rename does not open the link."""
    shared, own = tmp_path / "shared", tmp_path / "own"
    shared.mkdir()
    shared.chmod(0o1777)
    own.mkdir()
    (own / "kept").write_text("before")
    link = shared / "link"
    link.symlink_to(own if kind == "folder" else own / "kept")
    path = link / "kept" if kind == "folder" else link
    for owner, content in ((12345, "before"), (os.getuid(), "after")):
        os.lchown(link, owner, owner)
        with nullcontext() if owner == os.getuid() else refuses("path"):
            write_file(path, "after")
        assert (own / "kept").read_text() == content
        assert sorted(file.name for file in own.iterdir()) == ["kept"]


def test_drafts_of_killed_processes_are_removed(tmp_path: Path) -> None:
    old, new, other = (tmp_path / name for name in (".mixed-ehl-0123.json", ".mixed-ehl-4567.json", ".other"))
    for path in (old, new, other):
        path.write_text("half")
    for path in (old, other):
        os.utime(path, (0.0, 0.0))
    write_file(tmp_path / "result.json", "whole")
    assert sorted(os.listdir(tmp_path)) == [new.name, other.name, "result.json"]
