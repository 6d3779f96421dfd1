"""The public interface of `regression`: one line for each step, and the same errors."""

import signal
from pathlib import Path

import pytest
from refusals import refuses
from small_plans import gear_plan, sweep_plan

import regression
from regression.data.result_files import read_run

XU = "xu_kahraman_2007"


def test_a_sweep_in_one_line_and_all_that_follows_from_it(tmp_path: Path) -> None:
    plan = regression.Plan.from_dict(sweep_plan("small"))
    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    run = regression.sweep(plan, tmp_path / "run", formula=XU, jobs=1)
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == handlers
    assert run.status.complete
    assert (run.unanswered, run.reports[0].converged) == (0, 16)
    frame = run.to_frame(units=True)
    assert {"pressure_hertz [Pa]", "friction_coefficient", "key"} <= set(frame)
    # the stored plan is the plan
    assert run.plan.plan_hash == plan.plan_hash == read_run(run.path)[0]["plan_hash"]
    assert run.plan.to_frame().equals(plan.to_frame())
    again = regression.sweep(plan, tmp_path / "run", formula=XU, jobs=1)
    assert (again.reports[0].resumed, again.reports[0].converged) == (16, 0)
    assert regression.load_dataset(run).data_hash == regression.Run(tmp_path / "run").dataset().data_hash
    assert run.merge(tmp_path / "cases.csv") == run.merge(tmp_path / "cases.h5") == 16
    with refuses("target"):
        run.merge(tmp_path / "cases.txt")
    for result in (plan, run, run.status, run.dataset()):
        for name in ("page.html", "tables.xlsx", "first.csv", "all.json"):
            assert result.report(tmp_path / name).stat().st_size > 0
    half = regression.sweep(plan, tmp_path / "half", formula="benedict_kelley_1961", jobs=1, shard="1/2")
    assert (half.status.finished, half.status.complete) == (8, False)
    assert len(half.status.table().rows) == 1
    assert len(half.status.failed_table().rows) == len(half.status.failed)
    # a formula has no other settings: the failed cases are tried with it again, and fail again
    assert len(half.retry(jobs=1).status.failed) == len(half.status.failed)


def test_a_fit_has_its_data_and_a_file_needs_them(tmp_path: Path) -> None:
    run = regression.sweep(regression.Plan.from_dict(gear_plan("fit", {"size": 64})), tmp_path, formula=XU, jobs=1)
    fitted = regression.fit(run, "power_law")
    fitted.save(tmp_path / "fitted.json")
    loaded = regression.Formula.load(tmp_path / "fitted.json")
    assert dict(fitted.to_frame()[["term", "value"]].to_numpy().tolist()) == loaded.coefficients
    titles = [section.title for section in fitted.sections()]
    assert titles == [section.title for section in loaded.sections(dataset=run)]
    for axes in (fitted.plot(), loaded.plot(dataset=run)):
        drawn = sum(len(points.get_offsets()) for points in axes.collections)
        assert drawn + sum(len(line.get_xdata()) for line in axes.lines) >= fitted.data.used
    for field, use in (
        ("dataset", loaded.sections),
        ("dataset", loaded.plot),
        ("nested", lambda: regression.fit(run, "power_law", nested=True)),
        ("hull", lambda: loaded.in_convex_hull("gear_fva3_noise")),
        ("friction model", lambda: regression.friction_model("0,05")),
    ):
        with refuses(field):
            use()


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"formula": "nothing"}, "formula"),
        ({"shard": (0, 2)}, "shard"),
        ({"shard": "²/8"}, "shard"),
        ({"time_cap": "1e300 s"}, "time_cap"),
        ({"retries": -1}, "retries"),
        ({"dask": "local:x"}, "dask"),
    ],
)
def test_errors_name_the_keyword(tmp_path: Path, options: dict[str, object], field: str) -> None:
    pytest.importorskip("distributed")
    with refuses(field):
        regression.sweep("demo", tmp_path, **{"formula": XU, **options})  # type: ignore[arg-type]
    assert not list(tmp_path.glob("*.jsonl"))


@pytest.mark.parametrize("name", ["folder", "container", "merge", "fit"])
def test_a_name_of_several_lines_is_not_written_into_a_script(name: str, tmp_path: Path) -> None:
    """It would end the text for `sbatch`, and its other lines would run on the login node."""
    given = {"folder": str(tmp_path), name: f"{tmp_path}/x\nEOF\ntouch planted\n"}
    with refuses("slurm"):
        regression.slurm_script("demo", tasks=2, **given)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["demo", "gear", "gear_mesh", "gear_film", "gear_fast", "gear_noise", "gear_paths"])
def test_a_plan_is_read_back_from_what_files_store(name: str) -> None:
    plan = regression.Plan.from_file(name)
    back = regression.Plan.from_json(plan.model_dump_json())
    assert back.plan_hash == plan.plan_hash
    assert back.case_at(5).model_dump_json() == plan.case_at(5).model_dump_json()
