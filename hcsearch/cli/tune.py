"""`hcsearch tune`: springs for a deployment that comes flat without a collision."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from hcsearch.cli.options import json_option, named_numbers
from hcsearch.cli.progress import Meter
from hcsearch.cli.subjects import request_of, subject_options
from hcsearch.errors import HcsearchError
from hcsearch.system.outputs import check_output, write_output

if TYPE_CHECKING:
    from hcsearch.subjects.reading import Subject
    from hcsearch.tuning.choice import SpringSet
    from hcsearch.tuning.robustness import Spread
    from hcsearch.tuning.tuning import Tuning


@click.command(
    epilog="Example: hcsearch tune thesis-4x4 --scene thesis --output springs.toml, then hcsearch deploy springs.toml; "
    "hcsearch tune square:012233230011:4 --catalogue 0.07,0.10"
)
@subject_options
@click.option(
    "--formulation",
    type=click.Choice(("constrained", "compliant")),
    help="Equations of motion.  [default: constrained, unless nothing comes flat in it]",
)
@click.option("--catalogue", metavar="K,K", help="Springs to be bought (N m/rad): none, one or two at each hinge.")
@click.option(
    "--evaluations",
    type=click.IntRange(min=1),
    default=500,
    show_default=True,
    help="Spring sets to search; choosing the formulation takes 16 or 32 more.",
)
@click.option("--samples", type=click.IntRange(min=0), default=64, show_default=True, help="Of the tolerances.")
@click.option(
    "--spread",
    "spreads",
    multiple=True,
    metavar="NAME=SHARE",
    help="Tolerance of stiffness, damping, mass (default 0.05 each) or start (0.001); may be repeated.",
)
@click.option("--spring-range", metavar="SOFT,STIFF", help="Bounds of a spring, N m/rad.  [default: by the scene]")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of all that is random.")
@json_option
@click.option("--output", metavar="FILE.toml", help="Write the scene with its springs: hcsearch deploy replays it.")
def tune(name: str, as_json: bool, **options: Any) -> None:
    """Choose the stiffness of each hinge so that the array comes flat without a collision (thesis 4.4).

    Mirror hinges get equal springs, of 0.001 to 0.2 N m/rad in the scene default and in proportion elsewhere, with
    dampers in proportion. Every evaluation is stored in the database: the same command again goes on where it stopped.
    Of the sets that are certified clear the one is chosen that is least likely to fail within the tolerances, with its
    catalogue springs where a catalogue is given.

    Exit code: 0 where the springs that are chosen come flat, certified clear; 1 where none do; 2 for wrong input.
    """
    from hcsearch.store import open_database
    from hcsearch.subjects.reading import read_subject
    from hcsearch.tuning.ledger import Ledger
    from hcsearch.tuning.tuning import tune as tuned

    if options["output"]:
        check_output(options["output"], (".toml",))
    catalogue, spread = _catalogue(options["catalogue"]), _spread(options["spreads"])
    subject = read_subject(request_of(name, options))
    if subject.drives is not None:
        raise HcsearchError(f"{name} has drives, and springs are tuned without: leave out its table [drive]")
    _check_catalogue(catalogue, subject)
    with open_database(options["db"], create=True) as database, Meter("set") as meter:
        tuning = tuned(
            subject.linkage,
            subject.scene,
            options["formulation"] or subject.formulation,
            catalogue=catalogue,
            evaluations=options["evaluations"],
            samples=options["samples"],
            spread=spread,
            seed=options["seed"],
            memory=Ledger(database, json.dumps(subject.key, sort_keys=True)),
            progress=meter,
        )
    if options["output"]:
        _write(options["output"], tuning, subject)
    if as_json:
        click.echo(json.dumps(_facts(tuning), indent=2, allow_nan=False))
    else:
        _print(tuning, subject)
    if tuning.interrupted:
        raise KeyboardInterrupt
    if not _chosen(tuning).confirmed:
        click.get_current_context().exit(1)


def _chosen(tuning: Tuning) -> SpringSet:
    """The springs to use: those of the catalogue where they are asked for and confirmed."""
    return tuning.rounded if tuning.rounded is not None and tuning.rounded.confirmed else tuning.best


def _write(path: str, tuning: Tuning, subject: Subject) -> None:
    """The scene with the springs to use."""
    from hcsearch.deployment.scene_files import file_text
    from hcsearch.deployment.springs import scene_springs

    if tuning.rounded is not None and not tuning.rounded.confirmed:
        click.echo(f"no catalogue springs are certified clear: {path} has the tuned ones", err=True)
    scene = scene_springs(tuning.scene, _chosen(tuning).stiffnesses)
    write_output(path, file_text(subject.facts, tuning.formulation, scene))


def _catalogue(text: str | None) -> tuple[float, ...]:
    if text is None:
        return ()
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise HcsearchError(f"{text!r} is no catalogue: write stiffnesses in N m/rad, such as 0.07,0.10") from error


def _check_catalogue(catalogue: tuple[float, ...], subject: Subject) -> None:
    """Refuse springs beyond the scene's range, before anything is computed."""
    from hcsearch.deployment.scales import settled
    from hcsearch.deployment.springs import range_of
    from hcsearch.tuning.catalogue import catalogue_levels

    if catalogue:
        catalogue_levels(catalogue, range_of(settled(subject.scene, subject.linkage))[1])


def _spread(texts: tuple[str, ...]) -> Spread:
    from hcsearch.tuning.robustness import SPREADS, Spread

    shares: dict[str, float] = {}
    twice = "--spread {} is given twice: leave one out"
    for text, name, share in named_numbers(texts, lambda name: HcsearchError(twice.format(name))):
        if name not in SPREADS or share is None or not 0.0 <= share <= 0.5:
            names = ", ".join(SPREADS)
            raise HcsearchError(f"{text!r} is no tolerance: write NAME=SHARE, a share from 0 to 0.5 of {names}")
        shares[name] = share
    return Spread(**shares)


def _facts(tuning: Tuning) -> dict[str, Any]:
    sets = {"start": tuning.start, "best": tuning.best, "rounded": tuning.rounded}
    return {
        "formulation": tuning.formulation,
        "spring_range_N_m_rad": list(tuning.scene.spring_range or ()),
        "seconds": tuning.scene.seconds,
        "use": advice(tuning),
        "tied_hinges": [list(hinges) for hinges in tuning.tied],
        **{name: None if one is None else _set_facts(one) for name, one in sets.items()},
        "evaluations": tuning.evaluations,
        "known_before": tuning.recalled,
        "interrupted": tuning.interrupted,
    }


def _set_facts(one: SpringSet) -> dict[str, Any]:
    check, precise, chance = one.check, one.deployment, one.robustness
    clearance = None if precise is None else precise.clearance
    return {
        "stiffness_N_m_rad": list(one.stiffnesses),
        "outcome": check.outcome,
        "clear": check.clear,
        "collision_s": None if check.collision is None else check.collision[0],
        "collision_panels": None if check.collision is None else list(check.collision[1]),
        "min_clearance_mm": None if check.gap is None else 1e3 * check.gap,
        "objective": one.value,
        "confirmed": one.confirmed,
        "flat_time_s": None if precise is None else precise.flat_time,
        "certified": None if clearance is None else clearance.kind,
        "samples": None if chance is None else chance.samples,
        "collision_probability": None if chance is None else chance.probability,
        "collision_interval_95": None if chance is None else list(chance.interval),
        "failure_interval_95": None if chance is None else list(chance.failure_interval),
    }


def _print(tuning: Tuning, subject: Subject) -> None:
    panels = subject.linkage.pattern.hinges
    low, high = tuning.scene.spring_range or (0.0, 0.0)
    click.echo(f"{'use':24}{advice(tuning)}")
    click.echo(f"{'formulation':24}{tuning.formulation}")
    click.echo(f"{'springs, N m/rad':24}{low:g} to {high:g}")
    click.echo(f"{'seconds':24}{tuning.scene.seconds:g}")
    click.echo(f"{'evaluations':24}{tuning.evaluations}, {tuning.recalled} of them known before")
    sets = [("start", tuning.start), ("tuned", tuning.best), ("catalogue", tuning.rounded)]
    shown = [(name, one) for name, one in sets if one is not None]
    for name, one in shown:
        click.echo(f"{name:24}{_sentence(one)}")
    click.echo(f"\n{'hinge':8}{'panels':10}" + "".join(f"{name:>12}" for name, _ in shown) + "  N m/rad")
    for hinge, own in enumerate(panels):
        values = "".join(f"{one.stiffnesses[hinge]:12.4g}" for _, one in shown)
        click.echo(f"{hinge:<8}{f'{own.first}, {own.second}':10}{values}")


def advice(tuning: Tuning) -> str:
    """What to rely on: the least favourable of the precise simulation and of the samples."""
    one = _chosen(tuning)
    name = "catalogue springs" if one is tuning.rounded else "tuned springs"
    if not one.confirmed:
        return f"none: no set that was tried comes flat, certified clear; the {name} come nearest"
    chance = one.robustness
    if chance is None or not chance.failures:
        return f"{name}: flat, certified clear" + ("" if chance is None else f", in all {chance.samples} samples too")
    share = f"{chance.failures} of {chance.samples} samples within the tolerances fail"
    if 2 * chance.failures > chance.samples:
        return f"none as built: {share}; certified clear holds for the {name} exactly as they are listed"
    return f"{name}, with care: {share}; certified clear holds for springs exactly as they are listed"


def _sentence(one: SpringSet) -> str:
    """What became of a set, in one line."""
    check, precise, chance = one.check, one.deployment, one.robustness
    text = check.reason
    if precise is not None:
        clear = precise.clearance is not None and precise.clearance.kind == "clear"
        text += f"; in a precise simulation {precise.reason}, {'' if clear else 'not '}certified clear"
    if chance is not None:
        low, high = chance.interval
        text += f"; collides in {chance.collisions} of {chance.samples} samples, {low:.0%} to {high:.0%} at 95 %"
    return text
