"""`hcsearch motion`: the motion of a linkage from a state, with its branches and singular states."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import UNTILS, sizes_text
from hcsearch.cli.cases import linkage_options
from hcsearch.cli.options import FiniteNumber, examples_epilog, json_option
from hcsearch.cli.progress import ProgressMeter
from hcsearch.system.figures import check_picture
from hcsearch.system.outputs import check_output
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    from hcsearch.motion.paths.linkage_motion import LinkageMotion

_MOST_BRANCHES = 20
"""Most branches that are printed."""
_SPACED_ROWS = 12
"""States that are printed, evenly spaced, beside the singular ones."""


@click.command(
    "motion",
    epilog=examples_epilog(
        "hcsearch motion unit-ii --picture unit-ii.svg --output unit-ii.csv",
        "hcsearch motion element-6r --from flat --branch 2 --degrees",
        "hcsearch motion hex:0234435011:1 --until event --output event.csv",
        "hcsearch motion hex:0234435011:1 --from event.csv --branch 1 --output motion.glb",
    ),
)
@linkage_options
@click.option(
    "--from",
    "start",
    metavar="folded|flat|FILE.csv",
    help="The state at which the motion starts; of a table of states, such as --output writes, the last row.  "
    "[default: folded]",
)
@click.option("--row", type=click.IntRange(min=0), metavar="K", help="The row of the table, from 0 on.")
@click.option(
    "--angles", metavar="A,A,...", help="The fold angles at which the motion starts, one for each hinge, in rad."
)
@click.option(
    "--branch",
    type=int,
    metavar="K",
    help="The branch to follow, numbered as listed; with --no-stops -K is its opposite sense.  [default: the finite "
    "one that leads most directly to flat, or from flat to folded]",
)
@click.option(
    "--until",
    type=click.Choice(UNTILS),
    default="end",
    show_default=True,
    help="Where the motion ends: at either end, at one of them, only at a stop, at the first singular state, or at the "
    "first bifurcation.",
)
@click.option(
    "--stops/--no-stops",
    default=True,
    help="Whether hinges stop at 0 and pi, where the motion ends, or turn on.  [default: stops]",
)
@click.option("--length", type=FiniteNumber(min=0, min_open=True), metavar="RAD", help="The greatest arc length, rad.")
@click.option(
    "--step",
    type=FiniteNumber(min=0, min_open=True),
    metavar="RAD",
    help="The greatest arc length between two states, rad.  [default: 0.05 x the root of the number of hinges]",
)
@click.option(
    "--degrees", is_flag=True, help="Read --angles, and write fold angles, in degrees, as pictures always show them."
)
@json_option
@click.option(
    "--output",
    "outputs",
    multiple=True,
    metavar="FILE",
    help="Write the table of states (.csv, .parquet), all results (.json), or the motion for other programs (.glb, "
    ".fold, .svg); may be repeated.",
)
@click.option(
    "--picture",
    metavar="FILE",
    help="Draw fold angles and the least singular value over arc length into a file .svg, .png or .pdf.",
)
def motion_(name: str, as_json: bool, **options: Any) -> None:
    """Follow the motion of a linkage from a state.

    The branches that begin at the state are found by the second-order equations of closure, and listed. One of them is
    followed by its arc length in the space of fold angles. On the way singular states are located: bifurcations, shaky
    states (a first-order motion more, but no branch), and dips of the least singular value. Loops are closed in every
    state, but panels may pass through each other.

    Exit code: 0 if the motion ends at the state that --until names, or with `end` at a stop; 1 if it ends elsewhere, or
    if no finite motion begins at the state; 2 for wrong input.
    """
    from hcsearch.api.exporting import save
    from hcsearch.api.following_motions import follow_motion
    from hcsearch.api.replaying import replay
    from hcsearch.motion.paths.linkage_motion import MOTION_SUFFIXES

    for path in options["outputs"]:
        _check_motion_output(path, MOTION_SUFFIXES)
    if options["picture"]:
        check_picture(options["picture"])
    named = ("scene", "panel", "flat_pairs", "db", "row", "branch", "until", "stops", "length", "step")
    arguments = {option: options[option] for option in named}
    with ProgressMeter("step") as meter:
        followed = follow_motion(name, start=_start(options), progress=meter, **arguments)
    degrees = options["degrees"]
    moving = [path for path in options["outputs"] if Path(path).suffix not in MOTION_SUFFIXES]
    played = replay(followed) if moving else None
    for path in options["outputs"]:
        if played is not None and path in moving:
            save(played, path)
        else:
            followed.save(path, degrees=degrees)
    if options["picture"]:
        followed.picture(options["picture"])
    facts = followed.facts(degrees=degrees)
    if as_json:
        click.echo(json.dumps(facts, indent=2, allow_nan=False))
    else:
        _print(followed, facts, degrees=degrees)
    if not followed.reached:
        click.get_current_context().exit(1)


def _check_motion_output(path: str, suffixes: tuple[str, ...]) -> None:
    """Check that a file can be written, before anything is computed."""
    from hcsearch.export.export_files import replay_export_format

    if Path(path).suffix in suffixes:
        check_output(path, suffixes)
        return
    replay_export_format(path).check_installed()
    check_output(path)


def _start(options: dict[str, Any]) -> Any:
    """Return the start as an argument of `follow_motion`."""
    if options["angles"] is None:
        return "folded" if options["start"] is None else options["start"]
    if options["start"] is not None:
        raise HcsearchError("give either --from or --angles: both say where the motion starts")
    try:
        angles = [float(part) for part in options["angles"].split(",")]
    except ValueError as error:
        text = options["angles"]
        raise HcsearchError(f"cannot read --angles {text!r}: write a number for each hinge, such as 0.5,1.2") from error
    return [math.radians(angle) for angle in angles] if options["degrees"] else angles


def _print(followed: LinkageMotion, facts: dict[str, Any], *, degrees: bool) -> None:
    """Print the start and its branches, the table of some states, the singular states, and the outcome."""
    stops = "stops at 0 and pi" if facts["stops"] else "no stops"
    click.echo(f"{facts['linkage']}: {sizes_text(facts)}; from {facts['start']}, {stops}")
    click.echo(facts["first_and_second_order"])
    for branch in facts["branches"][:_MOST_BRANCHES]:
        _print_branch(branch, followed=branch["branch"] == abs(facts["branch"] or 0))
    if len(facts["branches"]) > _MOST_BRANCHES:
        click.echo(f"  and {len(facts['branches']) - _MOST_BRANCHES} more, which --json lists")
    _print_rows(followed)
    for event in facts["events"]:
        place = f"arc length {short_number(event['arc_length_rad'], 6)} rad, nullity {event['nullity']}"
        angles = event["angles_deg" if degrees else "angles_rad"]
        click.echo(f"{event['kind']} at {place}; fold angles {_by_value(angles, 2 if degrees else 4)}")
        if event["at_stops"]:
            click.echo(f"  at stops: {' '.join(map(str, event['at_stops']))}")
    click.echo(facts["reason"])


def _print_branch(branch: dict[str, Any], *, followed: bool) -> None:
    family = f", family of dimension {branch['family_dimension']}" if branch["family_dimension"] else ""
    stops = "" if branch["within_stops"] else ", beyond the stops"
    turning = {name: rate for name, rate in branch["direction"].items() if abs(rate) >= 0.5e-3}
    rates = _by_value(turning, 3) + (", else 0" if len(turning) < len(branch["direction"]) else "")
    mark = ">" if followed else " "
    click.echo(f"{mark} branch {branch['branch']}: {branch['status']}{family}{stops}; rates {rates}")


def _by_value(numbers: dict[str, float], digits: int) -> str:
    """Return numbers of hinges as text, each number once, with the hinges that have it."""
    hinges: dict[str, list[str]] = {}
    for name, number in numbers.items():
        hinges.setdefault(f"{round(number, digits) + 0.0:.{digits}f}", []).append(name)
    return ", ".join(f"{number} at {' '.join(names)}" for number, names in hinges.items())


def _print_rows(followed: LinkageMotion) -> None:
    """Print states at even steps of arc length, and all singular ones, without their fold angles."""
    rows = followed.rows
    spaced = [0.0] if not rows.lengths[-1] else [rows.lengths[-1] * k / _SPACED_ROWS for k in range(_SPACED_ROWS + 1)]
    shown = {int(abs(rows.lengths - length).argmin()) for length in spaced}
    shown |= {k for k, kind in enumerate(rows.kinds) if kind}
    click.echo(f"{'row':>5}{'arc length, rad':>17}{'nullity':>9}{'least singular value':>22}{'residual':>10}")
    for k in sorted(shown):
        nullity = "-" if rows.nullities[k] < 0 else str(rows.nullities[k])
        value = "-" if math.isnan(rows.least_values[k]) else f"{rows.least_values[k]:.6f}"
        event = f"  {rows.kinds[k]}" if rows.kinds[k] else ""
        click.echo(f"{k:5}{rows.lengths[k]:17.4f}{nullity:>9}{value:>22}{rows.residuals[k]:10.0e}{event}")
