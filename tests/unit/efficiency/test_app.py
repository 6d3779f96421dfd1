"""The page of `mixed-ehl app`: what it answers is what the Python interface answers; nonsense makes a sentence."""

import base64
import http.client
import importlib.util
import os
import shutil
import socket
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from email.message import Message
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from typer.testing import CliRunner

import efficiency
from efficiency.app.charts import efficiency_map, losses, stacked, tooth
from efficiency.app.scene import AXLE_FIELDS, SHAPE, Bench, Scene, changed
from efficiency.cli import app
from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.common.files import toml_text
from ehl.common.progress import Progress
from ehl.common.validation import read_toml
from regression.friction.published_registry import model_label

PAIR = "fm_spiral_bevel_14x39_relieved"
BENCH = Bench()
SCENE = Bench().start(PAIR)


def test_answers_are_those_of_the_python_interface() -> None:
    at = {"torque": "250", "speed": "900", "temperature": "70", "E": "0.05"}
    asked = changed(SCENE, roughness_rms_gear="0.3", peklenik_number="2", **at)
    found = BENCH.answer(asked)
    loaded = efficiency.load(PAIR).mesh(side="drive", E="0.05 mm").load("250 N m")
    rough = {"roughness_rms_pinion": f"{SCENE.roughness_rms_pinion} um", "roughness_rms_gear": "0.3 um"}
    expected = loaded.efficiency("75w90", speed="900 rpm", temperature="70 degC", peklenik_number=2.0, **rough)
    assert found.result.efficiency == expected.efficiency
    # a slider of speed or finish evaluates only the formula
    assert BENCH.answer(changed(asked, speed="1000")).loaded is found.loaded
    assert BENCH.answer(changed(asked, torque="240")).loaded is not found.loaded


def test_pictures_hold_the_contact() -> None:
    answer = BENCH.answer(SCENE)
    points, top = answer.tooth("pressure_hertz")
    assert len(points) > 500
    assert top == pytest.approx(1e-9 * answer.result.pressure_hertz_max, rel=0.05)
    # within the face and the height of the gear tooth
    corners = answer.outline()
    for axis in (0, 1):
        low, high = min(c[axis] for c in corners), max(c[axis] for c in corners)
        assert low - 0.5 < min(p[axis] for p in points) < max(p[axis] for p in points) < high + 0.5
    assert len(tooth(answer, "loss_density")["series"][0]["data"]) == len(points)
    rows = BENCH.compared(SCENE)
    assert all(low <= loss <= high for _, loss, low, high in rows)
    assert losses(rows)["series"][0]["data"][0] == round(rows[0][1], 2)
    states: list[Progress] = []
    torques, speeds, map_rows = BENCH.map(SCENE, states.append)
    assert states[-1].done == states[-1].total == len(torques) * len(speeds)
    assert map_rows[-1][-1] > map_rows[0][0]
    assert len(efficiency_map(torques, speeds, map_rows)["series"][0]["data"]) == len(torques) * len(speeds)


def test_axle_of_the_tab_is_that_of_the_python_interface() -> None:
    texts = {name: start for name, (_, start) in AXLE_FIELDS.items()}
    texts |= {"axle": "eaxle_helical", "churning": "iso_14179_2"}
    found = BENCH.axle_point(texts)
    own = efficiency.Axle("eaxle_helical", methods={"churning": "iso_14179_2"})
    assert found.points == own.at("200 N m", "1500 rpm", "80 degC").points
    speeds, by_source = BENCH.axle_speeds(texts)
    at = speeds.index(1500.0)
    assert sum(losses[at] for losses in by_source.values()) == pytest.approx(found.points[0].loss_total, rel=3e-3)
    assert [series["name"] for series in stacked(speeds, by_source)["series"]] == list(by_source)
    balanced = BENCH.axle_point(texts | {"temperature": "balance"}).points[0]
    assert abs(balanced.heat_stored) < 1e-3 * balanced.loss_total
    for name, text in (("axle", "../../pyproject.toml"), ("torque", "a lot"), ("speed", "1,200"), ("churning", "none")):
        with pytest.raises(InputError, match=name):
            BENCH.axle_point(texts | {name: text})


NONSENSE = {
    "torque": ("-5", "a lot"),
    "speed": ("1e400", "1,200", "0"),  # a thousand, or a decimal comma
    "temperature": ("2000",),
    "roughness_rms_gear": ("x" * 9999,),
    "peklenik_number": ("0",),
    "E": ("40",),
    "side": ("sideways",),
    "oil": ("../secret.toml", "mine.toml"),
    "friction": ("/etc/hostname", "ehl"),
    "finish": ("polished",),
    "design": ("../../pyproject.toml",),
}


@pytest.mark.parametrize(("field", "text"), [(field, text) for field, texts in NONSENSE.items() for text in texts])
def test_nonsense_is_refused_by_field_and_opens_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, field: str, text: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(efficiency.new_file("oil"), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        BENCH.answer(changed(SCENE, **{field: text}))
    assert {problem.field.rpartition(".")[2] for problem in caught.value.problems} == {field}
    assert len(str(caught.value)) < 2000


def test_all_problems_at_once_by_field() -> None:
    wrong = {"torque": "-5", "speed": "1,200", "temperature": "2000", "roughness_rms_gear": "40", "E": "3"}
    asked = changed(SCENE, **wrong)
    with pytest.raises(InputError) as caught:
        BENCH.answer(asked)
    found = BENCH.problems(asked, caught.value)
    assert (found.keys(), "degC" in found["temperature"]) == (wrong.keys(), False)


def test_finish_by_name(tmp_path: Path) -> None:
    fine = changed(SCENE, finish="superfinished, new", **BENCH.roughness(SCENE.design, "superfinished, new"))
    found = BENCH.answer(fine).result
    pair = efficiency.load(PAIR).finished("superfinished", "new")
    assert float(fine.roughness_rms_gear) == 1e6 * pair.design.gear.roughness_rms == 0.12
    expected = pair.mesh(side="drive").load().efficiency("75w90").efficiency
    # the balance of torque begins where the last answer ended
    assert found.efficiency == pytest.approx(expected, abs=found.efficiency_error)
    assert found.efficiency > BENCH.answer(SCENE).result.efficiency
    design = tmp_path / "design.toml"
    design.write_text(BENCH.design_text(fine), encoding="utf-8")
    again = efficiency.load(design)
    assert again.design.pinion.surface_finish() == pair.design.pinion.surface_finish()


@pytest.mark.parametrize("shape", [{}, {"lengthwise_crowning": "60", "tip_relief": "10"}])
def test_files_give_the_number_of_the_page(tmp_path: Path, shape: dict[str, str]) -> None:
    asked = changed(SCENE, speed="1000", roughness_rms_pinion="0.25", P="-0.04", torque="", **shape)
    expected = BENCH.answer(asked).result.efficiency
    design = tmp_path / "design.toml"
    design.write_text(BENCH.design_text(asked), encoding="utf-8")
    pair = efficiency.load(design)
    assert pair.mesh(side="drive").load().efficiency("75w90").efficiency == pytest.approx(expected, abs=1e-12)
    # a file of the command line is listed under its own name with the shipped ones
    own = Bench(design)
    assert own.designs[0] == "design.toml"
    assert own.answer(own.start()).result.efficiency == pytest.approx(expected, abs=1e-12)
    if shape:
        assert expected != BENCH.answer(changed(asked, **dict.fromkeys(SHAPE, ""))).result.efficiency
    said: dict[str, object] = {}
    exec(compile(BENCH.script(asked), "script", "exec"), said)
    assert said["result"].efficiency == expected  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", BENCH.designs)
def test_every_shipped_design_is_written_as_it_reads(name: str) -> None:
    content = read_toml(data_path("designs", f"{name}.toml"))
    assert tomllib.loads(BENCH.design_text(Scene(name))) == content


def test_toml_of_what_no_shipped_design_holds() -> None:
    content = {"on": True, "parts": [{"a b": 1.5, "text": 'say "x"'}], "table": {"empty": {}}}
    assert tomllib.loads(toml_text(content)) == content


def test_where_nothing_can_carry_the_load_there_is_no_number() -> None:
    answer = BENCH.answer(changed(SCENE, torque="1000000"))
    assert answer.headline() == "no result"
    assert answer.notes[0].grade == "fault"
    assert len(answer.tooth("pressure_hertz")[0]) > 0
    # the contact that loses most is one of the mesh
    point = BENCH.contact(SCENE).line_contact()
    low, high = BENCH.answer(SCENE).result.friction_range.ranges["pressure_hertz"]
    assert low <= point.pressure_hertz <= high


def test_command_without_its_extra_or_port(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        found = CliRunner().invoke(app, ["app", "--port", str(taken.getsockname()[1])])
    assert isinstance(found.exception, InputError)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    found = CliRunner().invoke(app, ["app"])
    assert "mixed-ehl[app]" in str(found.exception)


SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport="
UPGRADE = {"Connection": "Upgrade", "Upgrade": "websocket"}
UPGRADE |= {"Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": base64.b64encode(bytes(16)).decode()}
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Caller:
    """Requests to the page of an address with its token."""

    def __init__(self, address: str) -> None:
        parts = urlsplit(address)
        self.address, self.port, self.host, self.query = address, parts.port, parts.netloc, parts.query

    def get(self, path: str, method: str = "GET", **headers: str) -> tuple[int, Message, str]:
        """Status, headers and content of an answer; names of headers with `_` for `-`."""
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60.0)
        given = {"Host": self.host} | {name.replace("_", "-"): text for name, text in headers.items()}
        line.request(method, path, headers=given)
        found = line.getresponse()
        content = "" if found.status == 101 else found.read().decode()
        line.close()
        return found.status, found.headers, content

    def socket(self, **headers: str) -> int:
        return self.get(f"{SOCKET}websocket", **UPGRADE, **headers)[0]


@pytest.fixture(scope="module")
def caller() -> Iterator[Caller]:
    with socket.socket() as trial:
        trial.bind(("127.0.0.1", 0))
        port = trial.getsockname()[1]
    command = [sys.executable, "-c", "from efficiency.cli import main; main()", "app", "--no-browser"]
    # with this variable NiceGUI waits for a test client of its own
    plain = {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}
    with subprocess.Popen([*command, "--port", str(port)], stderr=subprocess.PIPE, env=plain, text=True) as server:
        printed = next(line.split()[0] for line in server.stderr if line.startswith("http://"))
        for _ in range(600):
            with socket.socket() as trial:
                if trial.connect_ex(("127.0.0.1", port)) == 0:
                    break
            time.sleep(0.1)
        try:
            yield Caller(printed)
            server.terminate()
            server.wait(30.0)
        finally:
            server.kill()


@pytest.fixture
def cookie(caller: Caller) -> str:
    status, headers, content = caller.get(f"/?{caller.query}")
    assert status == 200
    assert "mixed-ehl" in content
    value, *attributes = headers["Set-Cookie"].split("; ")
    assert set(attributes) == {"Path=/", "HttpOnly", "SameSite=Strict"}
    return str(value)


def allowed(headers: Message) -> list[str]:
    """Headers by which pages of others may read an answer."""
    return [name for name in headers if name.lower().startswith("access-control")]


def test_page_opens_with_its_token_alone(caller: Caller, cookie: str) -> None:
    origin = f"http://{caller.host}"
    assert caller.get("/", Cookie=cookie)[0] == 200
    assert caller.get("/", Cookie=f'other={{"a": [1, 2]}}; {cookie}')[0] == 200
    for path in ("/", f"{SOCKET}polling"):
        status, headers, _ = caller.get(path, Cookie=cookie, Origin=origin)
        assert (status, allowed(headers)) == (200, [])
    assert caller.socket(Cookie=cookie, Origin=origin) == 101
    assert caller.get("/", Cookie=cookie, Host=f"localhost:{caller.port}")[0] == 200
    name = cookie.partition("=")[0]
    for wrong in ({}, {"Cookie": f"{name}="}, {"Cookie": f"{name}=x"}, {"Cookie": "\xe4=\xe4;;="}):
        status, headers, content = caller.get("/", **wrong)
        assert (status, headers["Set-Cookie"]) == (403, None)
        assert "efficiency" not in content
        assert caller.get(f"{SOCKET}polling", **wrong)[0] == 403
        assert caller.socket(Origin=origin, **wrong) == 403
    for query in ("token=", "token=x", "token=%ff", "token"):
        assert caller.get(f"/?{query}")[0] == 403


def assert_refused(caller: Caller, **foreign: str) -> None:
    for path in (f"/?{caller.query}", f"{SOCKET}polling"):
        for method in ("GET", "OPTIONS"):
            status, headers, _ = caller.get(path, method, **foreign)
            assert (status, allowed(headers)) == (403, [])
    assert caller.socket(**foreign) == 403


@pytest.mark.parametrize(
    "host", ["attacker.example", "attacker.example:{port}", "127.0.0.1", "localhost:1", "127.0.0.1:{port}.example", ""]
)
def test_names_of_others_are_refused(caller: Caller, cookie: str, host: str) -> None:
    """DNS rebinding: a name of another owner is led to 127.0.0.1."""
    foreign = host.format(port=caller.port)
    assert_refused(caller, Host=foreign, Cookie=cookie)
    assert_refused(caller, Host=foreign, Cookie=cookie, Origin=f"http://{foreign}")


@pytest.mark.parametrize(
    "origin", ["http://attacker.example", "null", "http://127.0.0.1", "https://{host}", "http://{host}.a"]
)
def test_pages_of_others_are_refused(caller: Caller, cookie: str, origin: str) -> None:
    assert_refused(caller, Origin=origin.format(host=caller.host), Cookie=cookie)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_page_in_a_browser(caller: Caller, tmp_path: Path) -> None:
    sync_api = pytest.importorskip("playwright.sync_api")
    # the loopback address of the page, not another one of this machine
    with socket.socket() as trial:
        assert trial.connect_ex(("127.0.0.2", caller.port)) != 0
    with sync_api.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page()
        faults: list[str] = []
        page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
        page.goto(caller.address)
        headline = page.locator(".text-3xl")
        scene = BENCH.start()
        expect = sync_api.expect
        expect.set_options(timeout=60_000)
        expect(headline).to_have_text(BENCH.answer(scene).headline(), timeout=240_000)
        expect(page.locator("canvas").nth(1)).to_be_visible(timeout=120_000)
        faster = changed(scene, speed="3000")
        page.get_by_label("pinion speed").fill("3000")
        expect(headline).to_have_text(BENCH.answer(faster).headline(), timeout=120_000)
        # two invalid fields: both are reported and marked, and the results below are marked as out of date
        page.get_by_label("pinion torque").fill("-3")
        page.get_by_label("oil temperature").fill("hot")
        expect(headline).to_have_text("no result", timeout=120_000)
        stale = page.get_by_text("The results below belong to the last valid settings")
        expect(stale).to_be_visible()
        expect(page.locator(".q-field--error")).to_have_count(2)
        page.get_by_label("oil temperature").fill(scene.temperature)
        expect(page.locator(".q-field--error")).to_have_count(1)
        page.get_by_label("pinion torque").fill(scene.torque)
        expect(headline).to_have_text(BENCH.answer(faster).headline(), timeout=120_000)
        expect(stale).to_be_hidden()
        expect(page.locator(".q-field--error")).to_have_count(0)
        # another tab begins with the design as it is, and leaves this one alone
        other = browser.new_page()
        other.goto(caller.address)
        expect(other.locator(".text-3xl")).to_have_text(BENCH.answer(scene).headline(), timeout=120_000)
        other.get_by_label("Rq gear").fill("0.2")
        smoother = changed(scene, roughness_rms_gear="0.2")
        expect(other.locator(".text-3xl")).to_have_text(BENCH.answer(smoother).headline(), timeout=120_000)
        other.close()
        expect(headline).to_have_text(BENCH.answer(faster).headline())
        # the slider of E, a little to the right
        slider = page.get_by_role("slider").nth(len(SHAPE))  # those of the flanks come first
        slider.click(position={"x": 0.6 * slider.bounding_box()["width"], "y": 8})
        offset = page.get_by_label("E offset")
        expect(offset).not_to_have_value(scene.E)
        moved = changed(faster, E=offset.input_value())
        assert 0.0 < float(moved.E) < 0.15
        expect(headline).to_have_text(BENCH.answer(moved).headline(), timeout=120_000)
        # finish and friction model by name
        finish, model = "ground, new", "xu_kahraman_2007"
        for label, choice, texts in (
            ("finish of both flanks", finish, {"finish": finish, **BENCH.roughness(scene.design, finish)}),
            ("friction model", model_label(model), {"friction": model}),
        ):
            page.get_by_label(label, exact=True).click()
            page.get_by_role("option", name=choice, exact=True).click()
            moved = changed(moved, **texts)
            expect(headline).to_have_text(BENCH.answer(moved).headline(), timeout=120_000)
        page.get_by_role("button", name="Efficiency map").click()
        expect(page.locator("canvas").nth(3)).to_be_visible(timeout=120_000)
        page.get_by_role("button", name="Film and pressure").click()
        expect(page.get_by_text("central film")).to_be_visible(timeout=240_000)
        assert page.locator("img").count() == 1
        old = page.get_by_text("For earlier settings")
        expect(old).to_have_count(2)
        expect(old.first).to_be_hidden()
        page.get_by_label("Rq pinion").fill("0.35")
        moved = changed(moved, roughness_rms_pinion="0.35")
        expect(headline).to_have_text(BENCH.answer(moved).headline(), timeout=120_000)
        expect(old.first).to_be_visible()
        expect(old.last).to_be_visible()
        page.get_by_role("button", name="light or dark").click()
        for label, suffix in (("Python script", "script.py"), ("Design file", "design.toml"), ("Report", "page.html")):
            with page.expect_download(timeout=120_000) as download:
                page.get_by_role("button", name=label).click()
            download.value.save_as(tmp_path / suffix)
        # a decimal comma, and a phone
        page.get_by_label("Rq pinion").fill("0,4")
        expect(headline).to_have_text("no result", timeout=120_000)
        page.set_viewport_size({"width": 360, "height": 780})
        expect(headline).to_be_visible()
        # figures follow the width a moment later; in time nothing is wider than the screen
        page.wait_for_function("document.documentElement.scrollWidth <= 360", timeout=60_000)
        browser.close()
    assert (tmp_path / "script.py").read_text(encoding="utf-8") == BENCH.script(moved)
    assert (tmp_path / "design.toml").read_text(encoding="utf-8") == BENCH.design_text(moved)
    assert BENCH.answer(moved).headline().partition(" ")[0] in (tmp_path / "page.html").read_text(encoding="utf-8")
    assert faults == []
