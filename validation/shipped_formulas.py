"""The data and the formulas that are shipped: sweep, merge, fit and check them.

    python validation/shipped_formulas.py              # all of it; the same command resumes
    python validation/shipped_formulas.py --fit        # from the data that are there
    python validation/shipped_formulas.py 75w90 --check  # tables alone

The plans `gear`, `gear_mesh`, `gear_film`, `gear_fast`, `gear_uncertain`, `gear_hot`, `gear_rapid`, `gear_pairs`,
`gear_noise`, `gear_hot_noise` and `gear_paths` are solved for each oil, 6200 contacts or 50 minutes of processor time;
results go to data/datasets and formulas to data/formulas. The last three check, the others are fitted.
Without names all shipped oils are meant. A sweep is resumed from its folder in validation/out/sweeps; the fits take
30 minutes of two cores.
"""

from __future__ import annotations

import itertools
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import OUT, command_line, one_of, write_rows

import efficiency
import ehl
import regression
from efficiency.conditions.duty import DutyRow
from regression.data.dataset import columns, load_dataset
from regression.export.export import LANGUAGES
from regression.fitting.rows import NORMAL_90, checkable_rows, computed_friction, expected_rows
from regression.friction.conditions import conditions_of
from regression.friction.models import FrictionEstimate

OILS = ("75w90", "fva3", "eaxle", "80w90", "pao220", "pg_0_1")
KINDS = ("", "_mesh", "_noise", "_paths", "_film", "_fast", "_uncertain", "_hot", "_hot_noise", "_rapid", "_pairs")
EVEN = ("", "_mesh", "_film", "_fast", "_hot")  # spread evenly over their ranges
TABLES = ("_uncertain", "_pairs")  # their points stand in a table for each oil
FITTED = (*EVEN, "_uncertain", "_rapid", "_pairs")
CHECKS = {"_noise": "noise", "_hot_noise": "noise", "_paths": "paths"}  # never fitted, with their name in the tables
PROFILES = {"_paths": 4}  # of each contact of a table, whose mean is the expected value; plans name their own
DATA = Path("data")
PAGE, MARKERS = Path("docs/friction_formula.md"), ("<!-- errors: begin -->", "<!-- errors: end -->")
PAIRS = (
    "fm_spiral_bevel_14x39", "fm_hypoid_13x42", "fh_hypoid_9x34", "fh_hypoid_9x34_offset_10", "fh_spiral_bevel_12x37",
)  # fmt: skip
SPEEDS = (100, 1500, 6000, 16_000, 20_000)  # of the pinion [rpm]
SUFFIXES = {"python": ".py", "c": ".c", "fortran": ".f90", "matlab": ".m", "fmu": ".fmu"}
SETTLED = 0.25  # stated error of solved contacts above which a comparison with them says little
BANDS = {
    "film_ratio": (0.0, 0.1, 0.5, 1.0, 2.0, np.inf),
    "peklenik_number": (0.0, 0.5, 1.0, 3.0, np.inf),
    "temperature_degC": (0.0, 60.0, 100.0, 140.0, np.inf),
}


def sweep(oil: str, jobs: int | None) -> None:
    """Solve what is missing of the plans and write the datasets."""
    for kind in KINDS:
        # every oil has its own points: together they say more than the same ones six times
        drawn = 2000 if kind in ("_noise", "_hot_noise") else 0  # drawn after the networks had been chosen
        seed = f"sampling.seed={drawn + 100 * OILS.index(oil) + KINDS.index(kind) + 1}"
        changes = [f"lubricant.oil={oil}", seed]
        if kind in TABLES:
            changes.append(f"table.file=gear{kind}_{oil}.csv")
        if kind in PROFILES:
            changes.append(f"sampling.realisations={PROFILES[kind]}")
        plan = regression.Plan.from_file(f"gear{kind}", changes)
        run = regression.sweep(plan, OUT / "sweeps" / f"{oil}{kind}", jobs=jobs)
        print(repr(run), flush=True)
        target = DATA / "datasets" / f"gear_{oil}{kind}.h5"
        new = target.with_suffix(".new.h5")
        new.unlink(missing_ok=True)
        run.merge(new, compress=True, complete=True)
        new.replace(target)


def fit(names: Sequence[str] = ("gear", *OILS)) -> None:
    """Fit the networks to the data of all oils (`gear`), tune them to each oil, and fit each oil's short form."""
    runs = {kind: [DATA / "datasets" / f"gear_{oil}{kind}.h5" for oil in OILS] for kind in KINDS}
    noise = [*runs["_noise"], *runs["_hot_noise"]]
    for name in names:
        formula = regression.fit(
            [run for kind in FITTED for run in runs[kind]], "network", noise=noise, paths=runs["_paths"],
            oil=None if name == "gear" else name,
        )  # fmt: skip
        save(formula, name)
    for number, oil in enumerate(OILS):
        # chosen contacts are rare ones, to which fifteen coefficients would give too much weight
        own = [runs[kind][number] for kind in EVEN]
        checks = {"noise": [runs["_noise"][number], runs["_hot_noise"][number]], "paths": runs["_paths"][number]}
        save(regression.fit(own, "short", **checks), f"{oil}_short")


def save(formula: regression.Formula, name: str) -> None:
    """Write a formula to the shipped ones."""
    formula.save(DATA / "formulas" / f"{name}.json")
    print(repr(formula), flush=True)


def errors(oil: str) -> pd.DataFrame:
    """Every contact that was not fitted: error of the network and of the short form, and whether the interval holds it.

    Columns formula ("network", "short"), oil, contacts ("noise", "paths"), bands, error, covered, widened,
    stated_error. `widened`: whether the interval with the scatter of the mean over the profiles holds it.
    """
    found = []
    for family, name in (("network", oil), ("short", f"{oil}_short")):
        formula = regression.Formula.load(DATA / "formulas" / f"{name}.json")
        for kind, contacts in CHECKS.items():
            frame = checkable_rows(load_dataset(DATA / "datasets" / f"gear_{oil}{kind}.h5").frame)
            frame = expected_rows(frame)
            value, mu = formula.evaluate(columns(frame)), computed_friction(frame)
            part = {
                "formula": family, "oil": oil, "contacts": contacts, "film_ratio": frame["film_ratio_formula"],
                "peklenik_number": frame["peklenik_number"], "temperature_degC": frame["temperature_oil"] - 273.15,
                "error": value.mu / mu - 1.0, "covered": (value.lower <= mu) & (mu <= value.upper),
                "widened": within_scatter(value, frame), "stated_error": frame["friction_error"],
            }  # fmt: skip
            found.append(pd.DataFrame(part))
    return pd.concat(found, ignore_index=True)


def within_scatter(found: FrictionEstimate, rows: pd.DataFrame) -> np.ndarray:
    """Whether means over profiles lie in the interval, widened by the 90 % interval of these means."""
    width, scatter = np.log(found.upper / found.mu), NORMAL_90 * np.sqrt(rows["noise_variance"].to_numpy())
    return np.abs(np.log(found.mu / computed_friction(rows))) <= np.hypot(width, scatter)


def summary(rows: pd.DataFrame, by: Sequence[str]) -> pd.DataFrame:
    """Number, mean, 95 % and bias of the error, share covered and mean stated error, for each kind of contacts."""
    return (
        rows.groupby([*by, "contacts"], sort=False, observed=True)
        .agg(
            number=("error", "size"),
            mean=("error", lambda e: e.abs().mean()),
            p95=("error", lambda e: e.abs().quantile(0.95)),
            bias=("error", "mean"),
            covered=("covered", "mean"),
            widened=("widened", "mean"),
            stated_error=("stated_error", "mean"),
        )
        .reset_index()
    )


def table_of(found: pd.DataFrame, by: Sequence[str]) -> str:
    """The rows of `summary` as a table of the page, both kinds of contacts side by side."""
    figures = ("mean", "p95", "bias", "covered", "widened", "stated_error")
    kinds = {"noise": "never fitted", "paths": "along meshes"}
    head = [*(name.replace("_", " ") for name in by)]
    for label in kinds.values():
        head += [f"{label}: number", "mean / 95 %", "bias", "covered", "stated error"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for key, group in found.groupby(list(by), sort=False, observed=True):
        cells = [str(part) for part in (key if isinstance(key, tuple) else (key,))]
        for kind in kinds:
            row = group[group["contacts"] == kind]
            if row.empty:
                cells += [""] * 5
                continue
            mean, p95, bias, covered, widened, stated = (100.0 * float(row[name].iloc[0]) for name in figures)
            number = str(int(row["number"].iloc[0]))
            cells += [number, f"{mean:.1f} / {p95:.0f} %", f"{bias:+.1f} %", f"{covered:.0f} ({widened:.0f}) %"]
            cells.append(f"{stated:.1f} %")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def microseconds(name: str) -> tuple[float, float]:
    """Processor time of mu, and of mu with interval and guard, at one of many points."""
    formula, random = regression.Formula.load(name), np.random.default_rng(1)
    state = ehl.ContactState.of(
        pressure_hertz=random.uniform(0.4e9, 1.5e9, 20_000), radius_equivalent=0.015, effective_modulus=226e9,
        speed_entrainment=random.uniform(1.0, 10.0, 20_000), slide_to_roll=0.3, temperature_oil=363.15,
        roughness_rms_1=0.4e-6, roughness_rms_2=0.4e-6,
    )  # fmt: skip
    conditions = conditions_of(state, ehl.Oil.load(formula.default_oil()))
    found = []
    for task in (formula.coefficient, formula.evaluate):
        task(conditions)
        clock = time.process_time()
        for _ in range(10):
            task(conditions)
        found.append((time.process_time() - clock) / 10 / 20_000 * 1e6)
    return found[0], found[1]


def share_outside(formula: regression.Formula) -> list[dict[str, object]]:
    """Share of the sliding power of the shipped pairs outside the ranges of a formula, at full and quarter torque."""
    rows: list[dict[str, object]] = []
    for name in PAIRS:
        pair = efficiency.load(name)
        at = pair.design.operation
        duty = [
            DutyRow(part * at.torque, rpm * np.pi / 30.0, at.temperature, 1.0) for rpm in SPEEDS for part in (1.0, 0.25)
        ]
        for points, row in zip(pair.duty_points(duty), duty, strict=True):
            outside = np.ravel(formula.outside(conditions_of(points.state, points.oil)))
            rows.append(
                {
                    "pair": name, "rpm": round(row.speed * 30.0 / np.pi), "torque": row.torque,
                    "outside": float(np.ravel(points.weight)[outside].sum() / points.weight.sum()),
                }
            )  # fmt: skip
    return rows


def check(oils: Sequence[str]) -> None:
    """Print and write all tables; those of all oils into the page."""
    rows = pd.concat([errors(oil) for oil in oils], ignore_index=True)
    for name, ends in BANDS.items():
        edges = [
            f"{low:g} to {high:g}" if np.isfinite(high) else f"above {low:g}" for low, high in itertools.pairwise(ends)
        ]
        rows[name] = pd.cut(rows[name], ends, right=False, labels=edges)
    OUT.mkdir(parents=True, exist_ok=True)
    rows.to_csv(OUT / "shipped_formulas_errors.csv", index=False)
    settled = rows[(rows["stated_error"] <= SETTLED) & (rows["formula"] == "network")]
    tables = [(rows, ["formula", name]) for name in ("oil", *BANDS)] + [(settled, ["formula", "film_ratio"])]
    parts = [table_of(summary(which.sort_values(by, kind="stable"), by), by) for which, by in tables]
    parts.insert(-1, f"Only contacts with a stated error of at most {100.0 * SETTLED:.0f} %:")
    text = "\n\n".join(parts)
    print(text)
    if set(oils) == set(OILS):
        page = PAGE.read_text(encoding="utf-8")
        start, end = (page.index(marker) for marker in MARKERS)
        PAGE.write_text(page[: start + len(MARKERS[0])] + "\n" + text + "\n" + page[end:], encoding="utf-8")
    for name in (oils[0], f"{oils[0]}_short"):
        plain, whole = microseconds(name)
        print(f"{name}: {plain:.2f} us a point, {whole:.2f} us with interval and guard")
        with tempfile.TemporaryDirectory() as folder:
            for language in LANGUAGES:
                path = Path(folder) / f"friction{SUFFIXES[language]}"
                regression.Formula.load(name).export(path, language)
                content = path.read_bytes()
                lines = content.count(b"\n")
                print(f"{name} in {language}: {len(content)} bytes" + (f", {lines} lines" if language != "fmu" else ""))
    outside = share_outside(regression.Formula.load(oils[0]))
    write_rows(OUT / "shipped_formulas_outside.csv", outside)
    for rpm in SPEEDS:
        largest = max(float(str(row["outside"])) for row in outside if row["rpm"] == rpm)
        print(f"{rpm} rpm: at most {100.0 * largest:.2f} % of the sliding power of a pair outside the ranges")


def main(argv: Sequence[str] | None = None) -> None:
    """Sweep, fit and check as selected."""
    parser = command_line(__doc__)
    parser.add_argument("oils", nargs="*", type=one_of(OILS))
    parser.add_argument("--fit", action="store_true", help="fit and check the data that are there")
    parser.add_argument("--check", action="store_true", help="print the tables alone")
    parser.add_argument("--jobs", type=int, help="worker processes of a sweep; all processors if not given")
    selected = parser.parse_args(argv)
    oils = selected.oils or OILS
    if not (selected.fit or selected.check):
        for oil in oils:
            sweep(oil, selected.jobs)
    if not selected.check:
        fit()
    check(oils)


if __name__ == "__main__":
    main()
