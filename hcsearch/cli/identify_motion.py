"""`hcsearch identify motion`: springs, damping and other values of a scene from films of a deployment."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any, cast

import click

from hcsearch.basics.errors import printable
from hcsearch.basics.vocabulary import MOTION_TERMS, MotionTerm
from hcsearch.cli.cases import film_options, resolve_named
from hcsearch.cli.options import FiniteNumber, examples_epilog, json_option
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    from hcsearch.springs.identification.identified_motion import HeldOutFilm, IdentifiedMotion
    from hcsearch.springs.identification.motion_adequacy import MotionEstimate


class MotionTerms(click.ParamType):  # type: ignore[type-arg]  # generic in the newest click alone
    """Terms of a scene, separated by commas."""

    name = "terms"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[MotionTerm, ...]:
        """Parse the terms; click.BadParameter for one that there is not."""
        terms = tuple(part.strip() for part in value.split(",")) if isinstance(value, str) else tuple(value)
        for term in terms:
            if term not in MOTION_TERMS:
                self.fail(f"{term!r} is no term: choose from {', '.join(MOTION_TERMS)}.", param, ctx)
        return cast("tuple[MotionTerm, ...]", terms)


@click.command(
    "motion",
    epilog=examples_epilog(
        "hcsearch identify motion film.csv hex:0234550132:4",
        "hcsearch identify motion one.csv two.csv thesis-4x4 --scene thesis --fit stiffness,drag --held-out three.csv",
    ),
)
@click.argument("files", metavar="ANGLES.csv...", nargs=-1, required=True)
@film_options
@click.option(
    "--fit",
    type=MotionTerms(),
    default="stiffness,damping,friction",
    show_default=True,
    metavar="TERM,...",
    help=f"What is fitted: {', '.join(MOTION_TERMS)}.",
)
@click.option(
    "--held-out",
    "held_out",
    multiple=True,
    metavar="FILE.csv",
    help="A film that is not fitted, but predicted; may be repeated.",
)
@click.option("--rate", type=FiniteNumber(), metavar="HZ", help="The rate of the frames; it takes the place of time_s.")
@json_option
def motion_of_films(files: tuple[str, ...], name: str, as_json: bool, **options: Any) -> None:
    """Fit springs, damping and other values of a scene to films of a deployment.

    A film is a table of fold angles: a column time_s, and a column for each measured hinge, named by its number in
    pictures and a unit, such as 7_deg or 7_rad. Cells may be empty. The moment of the release is fitted for each film.
    Models are tried from the scene as it is to the one with all terms, and the simplest is chosen that no further term
    improves significantly. Its values are printed in the form that a scene file takes.

    Exit code: 0 if a model explains the films, also those that are held out; 1 if none does; 2 for wrong input.
    """
    from hcsearch.api import identifying

    case = resolve_named(name, options)
    identified = identifying.identify_motion(
        files, case, fit=options["fit"], held_out=options["held_out"], rate=options["rate"]
    )
    if as_json:
        click.echo(json.dumps(identified.facts(), indent=2, allow_nan=False))
    else:
        _print(identified)
    if not identified.explained:
        click.get_current_context().exit(1)


def _print(identified: IdentifiedMotion) -> None:
    """Print verdict, parameters, models and held-out films, then the values as lines of a scene file."""
    from hcsearch.springs.identification.identified_motion import scene_lines

    click.echo(f"{'verdict':14}{printable(identified.reason)}")
    left = identified.chosen.left
    click.echo(f"{'left':14}{_degrees(left.residual)} degrees rms; noise of the films {_degrees(left.noise)} degrees")
    for film, release in zip(identified.films, identified.chosen.releases, strict=True):
        click.echo(f"{'released':14}{short_number(release)} s, on the clock of {printable(film)}")
    for estimate in identified.estimates:
        _print_estimate(estimate)
    width = max(len("model tried"), *(len(_model(fit.terms)) for fit in identified.fits)) + 2
    click.echo(f"\n{'model tried':{width}}{'left, rms deg':>14}{'no noise, deg':>15}{'sureness':>10}  verdict")
    for fit in identified.fits:
        verdict = "explains" if fit.explained else "does not explain"
        verdict = f"chosen, {verdict}" if fit is identified.chosen else verdict
        numbers = f"{_degrees(fit.left.residual):>14}{_degrees(fit.left.misfit):>15}{f'{fit.sureness:.3f}':>10}"
        click.echo(f"{_model(fit.terms):{width}}{numbers}  {verdict}")
    for held_out in identified.validation:
        click.echo(_held_out_line(held_out))
    if identified.values:
        click.echo(f"\n{scene_lines(identified.values).rstrip()}")


def _print_estimate(estimate: MotionEstimate) -> None:
    value = f"{estimate.value:.4g} {estimate.unit}".rstrip() + ("" if estimate.unit else " times the scene's")
    if not estimate.identified:
        click.echo(f"{estimate.name:14}not identified by the films (least squares at {value})")
        return
    interval = f"95 %: {estimate.low:.4g} to {estimate.high:.4g}"
    click.echo(f"{estimate.name:14}{value}, standard error {estimate.error:.2g} ({interval})")


def _held_out_line(held_out: HeldOutFilm) -> str:
    verdict = "predicted" if held_out.predicted else "not predicted"
    left = held_out.left
    return (
        f"\n{'held out':14}{printable(held_out.film)}, released at {short_number(held_out.release)} s: {verdict}, "
        f"{_degrees(left.residual)} degrees rms, of which {_degrees(left.misfit)} no noise"
    )


def _model(terms: tuple[MotionTerm, ...]) -> str:
    return ", ".join(terms) or "the scene as it is"


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3g}"
