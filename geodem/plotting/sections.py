"""The parts of the report, each made from plain data; an empty string where there is nothing to tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geodem.plotting import page, wording
from geodem.plotting.page import Markup, text
from geodem.plotting.scenes import mean_spacing
from geodem.plotting.views import MethodView, ReportView
from geodem.stability.criteria import Criteria

STATIC = (
    "Static result (quasi-static relaxation), not dynamics: the displacements show which mass moves and in "
    "which "
    "direction; how large they are only tells where the trial was stopped. It is no forecast of run-out, "
    "and steps "
    "are not time."
)


CHARTS = {
    "bracket": "Every trial as a mark; the band between highest stable and lowest failed factor closes.",
    "history": "Displacement of what moves in each trial: one that levels off is stable, one that runs away "
    "has failed; the rule that decided stands in the table. Bold: the two ends of the bracket.",
}


@dataclass(frozen=True)
class Picture:
    """A figure as PNG, as SVG where it is a chart, and how many times displacements are drawn in it."""

    png: bytes
    svg: bytes | None = None
    scale: float = 0.0


def failure(view: ReportView, pictures: Mapping[str, Picture], names: Mapping[str, str]) -> str:
    """How the ground fails: one picture of everything, then displacement and shear strain."""
    shown = [method for method in view.methods if method.failure is not None]
    if not shown:
        reason = "No trial failed, so there is no failed state to show."
        return page.section("failure", "How it fails", f"<p>{reason}</p>") if view.methods else ""
    blocks = [f'<p class="static">{text(STATIC)}</p>']
    for method in shown:
        if len(view.methods) > 1:
            blocks.append(f"<h3>{text(_failed_title(method))}</h3>")
        blocks.append(_mass(method, view))
        name = names.get(method.kind, method.kind)
        whole = pictures[f"{name}-failure"]
        scaled = (
            f", and the deformed outline with displacements drawn {whole.scale:g} times"
            if whole.scale
            else ""
        )
        blocks.append(
            page.figure(
                whole.png,
                f"Materials, supports and loads, moving mass, traced slip surface{scaled}. Dashed: surfaces "
                "of "
                "other methods, where there are any.",
                alternative="Section at failure with slip surface",
            )
        )
        halves = [
            page.figure(
                pictures[f"{name}-displacement"].png,
                "Displacement from the settled state; arrows point where the ground goes, as long as it "
                "moves there.",
                alternative="Displacement at failure",
                wide=False,
            ),
            page.figure(
                pictures[f"{name}-shear-strain"].png,
                "Plastic shear strain: where the ground yields. Dashed: the slip surface traced from the "
                "displacements.",
                alternative="Plastic shear strain at failure",
                wide=False,
            ),
        ]
        blocks.append(f'<div class="grid">{"".join(halves)}</div>')
    return page.section("failure", "How it fails", *blocks)


def bracket(view: ReportView, pictures: Mapping[str, Picture], names: Mapping[str, str]) -> str:
    """How the factor was found: charts and table of trials, per method."""
    blocks = []
    for method in view.methods:
        if not method.trials and not method.histories:
            continue
        name = names.get(method.kind, method.kind)
        blocks.append(f"<h3>{text(wording.NAMES.get(method.kind, method.kind).capitalize())}</h3>")
        for chart, caption in CHARTS.items():
            picture = pictures.get(f"{name}-{chart}")
            if picture is not None and picture.svg is not None:
                blocks.append(page.figure(picture.svg, caption, alternative=caption, kind="image/svg+xml"))
        if method.trials:
            blocks.append(_trials(method))
    return page.section("bracket", "How the factor was found", *blocks) if blocks else ""


def ground(
    result: Mapping[str, Any],
    view: ReportView,
    pictures: Mapping[str, Picture],
    source: tuple[bytes, str] | None,
    trouble: str,
) -> str:
    """The section as particles, beside the picture that it was read from."""
    drawn = pictures["particles"].png
    caption = (
        "The particles on their materials, true to scale. Hatched wall: fixed, held in both directions. "
        "Wheels: "
        "roller, held across the boundary only."
    )
    blocks = []
    if source is not None:
        data, kind = source
        halves = page.figure(
            data,
            f"As given: {getattr(view.image_path, 'name', view.image_path)}",
            alternative="Source picture",
            kind=kind,
            wide=False,
        )
        halves += page.figure(drawn, caption, alternative="Section and particles", wide=False)
        blocks.append(f'<div class="grid">{halves}</div>')
    else:
        if trouble:
            blocks.append(f'<div class="note"><p>{text(trouble)}</p></div>')
        blocks.append(page.figure(drawn, caption, alternative="Section and particles"))
    low, high = view.positions.min(axis=0), view.positions.max(axis=0)
    spacing = view.spacing or mean_spacing(view.positions, view.triangles)
    sides = [f"{side}: {kind}" for side, kind in view.supports.items()]
    loads = [view.loads] if isinstance(view.loads, str) else list(view.loads)
    rows: list[tuple[str, str]] = [
        ("Particles", f"{len(view.positions):,}"),
        ("Triangles", f"{len(view.triangles):,}"),
        ("Spacing", f"{spacing:.3g} m"),
        ("Width and height", f"{high[0] - low[0]:.4g} m by {high[1] - low[1]:.4g} m"),
        ("Area", f"{_area(view):,.4g} m²"),
    ]
    blocks.append(page.pairs(rows))
    blocks.append(f"<p><strong>Supports.</strong> {text('; '.join(sides) or 'none given')}.</p>")
    told = "; ".join(load for load in loads if load) or "self-weight only"
    blocks.append(f"<p><strong>Loads.</strong> {text(told)}.</p>")
    return page.section("section", "Section and particles", *blocks)


def materials(view: ReportView) -> str:
    """Every property as used, with its unit; one column a material, so that many properties fit a page."""
    if not view.material_rows:
        return ""
    properties = list(dict.fromkeys(key for row in view.material_rows for key in row if key != "name"))
    rows = [[key, *(row.get(key, "") for row in view.material_rows)] for key in properties]
    header = ["", *(row.get("name", "") for row in view.material_rows)]
    return page.section("materials", "Materials", page.table(header, rows))


def energy(result: Mapping[str, Any]) -> str:
    """Work done and where it went, and by how much the account fails to close."""
    accounts = result.get("energy")
    if not accounts:
        return ""
    several = {key: value for key, value in accounts.items() if isinstance(value, Mapping)}
    if not several:
        several = {"": accounts}
    blocks = [
        "<p>Work per metre of section. What the loads did must be found again as elastic energy, plastic "
        "work, "
        "damping and motion; the closure error is what is missing.</p>"
    ]
    for kind, account in several.items():
        if kind:
            blocks.append(f"<h3>{text(wording.NAMES.get(kind, kind).capitalize())}</h3>")
        account = {str(key).removesuffix("_J_per_m"): value for key, value in account.items()}
        work = account.get("external_work")
        rows = []
        for key, value in account.items():
            name = key.replace("_", " ")
            if not isinstance(value, (int, float)) or isinstance(value, bool):
                rows.append([name, text(value), ""])
            elif "closure" in name:
                rows.append(
                    [
                        f"{name} error" if "error" not in name else name,
                        f"{wording.number(100.0 * value, digits=3)} %",
                        "",
                    ]
                )
            elif "[" in name or "ratio" in name or "factor" in name:
                rows.append([name, wording.number(value), ""])
            else:
                share = f"{100.0 * value / work:.1f} %" if isinstance(work, (int, float)) and work else ""
                rows.append([name, f"{wording.number(value)} J/m", share])
        blocks.append(
            page.table(["", "per metre of section", "share of external work"], rows, numbers=(1, 2))
        )
    return page.section("energy", "Energy", *blocks)


def run(result: Mapping[str, Any]) -> str:
    """Settings, defaults taken, versions, and what the run cost."""
    told = {
        "workflow": "Workflow", "status": "Status", "kind_of_result": "Kind of result",
        "particles": "Particles", "stress_points": "Stress points", "spacing_m": "Spacing [m]",
        "spacing_where_it_failed": "Spacing where it failed, over that [-]",
        "dimension": "Dimensions", "tolerance": "Tolerance [-]", "steps": "Relaxation steps",
        "wall_time_s": "Run time", "compile_time_s": "of which compiling",
        "seconds_to_first_step": "To the first step", "threads": "Threads", "seed": "Seed",
        "command": "Command", "digest": "Fingerprint of the bits",
    }  # fmt: skip
    kept = {
        *told, "factors", "energy", "versions", "warnings", "notices", "neighbours", "neighbours_why",
        "reference", "settings", "cracks", "title",
    }  # fmt: skip
    rows: list[tuple[object, object]] = []
    for key, name in told.items():
        value = result.get(key)
        if value is None or value == "":
            continue
        if key.startswith("seconds_") or key.endswith("_s"):
            rows.append((name, wording.seconds(value)))
        elif key == "digest":
            rows.append((name, str(value)[:16]))
        else:
            rows.append((name, f"{value:.4g}" if isinstance(value, float) else _plain(key, value)))
    settings = result.get("settings")
    more = dict(settings) if isinstance(settings, Mapping) else {}
    more |= {
        key: value
        for key, value in result.items()
        if key not in kept and isinstance(value, (int, float, str)) and not isinstance(value, bool)
    }
    rows += [(_label(str(key)), _plain(str(key), value)) for key, value in more.items()]
    cracks = result.get("cracks")
    if isinstance(cracks, Mapping) and any(cracks.values()):
        rows += [(f"Cracks in {name}", f"{count:,}") for name, count in cracks.items()]
    blocks = [page.pairs(rows)]
    notices = result.get("notices") or ()
    if notices:
        blocks += ["<h3>Defaults that were taken, and other notices</h3>", page.bullets(notices)]
    versions = result.get("versions")
    if isinstance(versions, Mapping) and versions:
        blocks += ["<h3>Versions</h3>", page.pairs(list(versions.items()))]
    return page.section("run", "Run", *blocks)


def case(view: ReportView) -> str:
    """The case file as it was run."""
    return page.section("case", "Case file", page.toml(view.case_text)) if view.case_text else ""


def reading(result: Mapping[str, Any]) -> str:
    """What the numbers mean and how a trial is judged."""
    items = [
        "<strong>Factor of safety</strong> (strength reduction): cohesion and tan φ are divided by a trial "
        "factor, "
        "the dilation angle is kept at or below the reduced friction angle and a tension cut-off is divided "
        "too. "
        "The factor of safety is the largest factor with which the ground still comes to rest.",
        "<strong>Gravity factor</strong> (gravity increase): the strength is kept and gravity is multiplied. "
        + text(wording.GRAVITY_WARNING),
        _criteria(),
        "<strong>Displacement of what moves</strong>: the mean over the section in which each part counts by "
        "how far it has moved (sum of area × displacement² over sum of area × displacement), so that a thin "
        "slab that "
        "slides off a large section counts as what it is.",
        "<strong>[stable, failed]</strong>: the factor lies between the two; the number given is their "
        "middle. The "
        "bracket is the accuracy of the search. The accuracy of the model (resolution, flow rule) and of "
        "the input "
        "comes on top and is commonly larger.",
        "<strong>Slip surface</strong>: the line across which the displacement drops from that of the "
        "moving mass to "
        "that of the ground that stays, traced at half of it; found, not assumed. Limit equilibrium "
        "(Bishop, Spencer) assumes a surface and looks for the worst.",
        "<strong>Plastic shear strain</strong>: shear that does not come back; a connected band from crest "
        "to toe is "
        "a mechanism.",
    ]
    return page.section(
        "reading", "How to read this", "<ul>" + "".join(f"<li>{item}</li>" for item in items) + "</ul>"
    )


def _criteria() -> str:
    """When a trial is stable and when it has failed, with the limits in force."""
    rules = Criteria()
    stable, balanced = (wording.powers(f"{ratio:g}") for ratio in (rules.stable_ratio, rules.balanced_ratio))
    return (
        f"<strong>Stable</strong>: the unbalanced force has fallen below {stable} of "
        "the weight. "
        f"<strong>Failed</strong>: what moves has moved more than {rules.failed_settlements:g} elastic settlements, "
        f"{rules.own_settlements:g} of them in this trial, "
        f"and is not slowing down (the unbalanced force is still above {100.0 * rules.steady:g} % of what it was "
        "half that way), "
        "or its displacement was still growing at the step limit. What has come so far, or to the step limit, "
        f"with an unbalanced force below {balanced} of the weight of what moves is in "
        "balance and counts as stable. "
        "<strong>Undecided</strong>: none of these when the steps ran out; such a trial is never counted as "
        "stable. The rule that decided stands with each trial."
    )


def _failed_title(method: MethodView) -> str:
    name = wording.NAMES.get(method.kind, method.kind).capitalize()
    if method.failed is None:
        return name
    changed = "strength divided by" if method.kind == "strength-reduction" else "gravity multiplied by"
    return f"{name}: {changed} {wording.bound(method.failed, method.stable)}"


def _mass(method: MethodView, view: ReportView) -> str:
    """The moving mass in figures."""
    state = method.failure
    if state is None or not state.moving.any():
        return "<p>No mass parts from the rest in this state.</p>"
    told = [f"{int(state.moving.sum()):,} particles move", f"moving area {state.moving_area:,.4g} m²"]
    if len(state.slip_surface):
        crest, toe = state.slip_surface[0], state.slip_surface[-1]
        length = float(np.hypot(*np.diff(state.slip_surface, axis=0).T).sum())
        told.append(
            f"slip surface {length:.3g} m long, from ({crest[0]:.4g}, {crest[1]:.4g}) m to ({toe[0]:.4g}, "
            f"{toe[1]:.4g}) m"
        )
        told.append(f"lowest point at y = {state.slip_surface[:, 1].min():.4g} m")
        if np.isfinite(state.band_distance):
            told.append(f"{state.band_distance:.2g} m on average from the ridge of plastic shear strain")
    return f"<p>{text('; '.join(told))}.</p>"


def _trials(method: MethodView) -> str:
    rows = []
    for number, trial in enumerate(method.trials, start=1):
        verdict = str(trial.get("verdict", ""))
        known = verdict if verdict in ("stable", "failed", "undecided") else ""
        rows.append(
            [
                number,
                f"{float(trial['factor']):.4f}",
                Markup(f'<span class="{known}">{text(verdict)}</span>'),
                wording.powers(str(trial.get("criterion", ""))),
                wording.number(trial.get("steps")),
                wording.number(trial.get("unbalanced"), digits=3),
                wording.number(trial.get("displacement"), digits=3),
                wording.number(trial.get("particles")),
                trial.get("model", ""),
                wording.number(trial.get("seconds"), digits=3),
            ]
        )
    header = [
        "Trial", "Factor [-]", "Verdict", "Told by", "Steps", "Unbalanced force ratio [-]",
        "Displacement of what moves [m]",
        "Particles", "Model", "Time [s]",
    ]  # fmt: skip
    return page.table(header, rows, numbers=(0, 1, 4, 5, 6, 7, 9), kind="trials")


def _area(view: ReportView) -> float:
    from geodem.measure.slip_surface import triangle_areas

    return float(triangle_areas(view.positions, np.asarray(view.triangles)).sum())


def _label(key: str) -> str:
    """A key of result.json in words: an ending that names a unit goes into brackets."""
    for ending, unit in (("_m2", "m²"), ("_m", "m"), ("_s", "s"), ("_percent", "%")):
        if key.endswith(ending):
            return f"{key.removesuffix(ending).replace('_', ' ').capitalize()} [{unit}]"
    return key.replace("_", " ").capitalize()


def _plain(key: str, value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {wording.number(entry)}" for name, entry in value.items())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(wording.number(entry) for entry in value)
    return str(value) if key == "seed" else wording.number(value)
