"""`hcsearch tune`: springs for a deployment that becomes flat without a collision."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.cases import case_options, resolve_named, subject_options
from hcsearch.cli.options import FiniteNumber, examples_epilog, json_option, named_numbers
from hcsearch.cli.progress import ProgressMeter
from hcsearch.springs.tuning.tuning_options import SPREAD_NAMES, Spread, TuningOptions, damper_bounds
from hcsearch.system.outputs import check_output, write_output
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    from hcsearch import Case, Tuning


@click.command(
    epilog=examples_epilog(
        "hcsearch tune thesis-4x4 --scene thesis --output springs.toml",
        "hcsearch deploy springs.toml",
        "hcsearch tune square:012233230011:4 --catalogue 0.07,0.10",
        "hcsearch tune thesis-4x4 --catalogue 0.07,0.10 --damper-catalogue 0.005,0.01",
        "hcsearch tune hex:0234550132:4 --rule ecss --friction 0.001 --output flight.toml",
    ),
)
@subject_options
@click.option(
    "--formulation",
    type=click.Choice(("constrained", "compliant")),
    help="The equations of motion.  [default: constrained, unless nothing becomes flat in it]",
)
@click.option(
    "--catalogue",
    metavar="K,K",
    help="Stiffnesses that can be bought, N m/rad; each hinge gets none, one or two of these springs.",
)
@click.option(
    "--most-damping",
    type=FiniteNumber(min=1, max=10),
    default=TuningOptions.most_damping,
    show_default=True,
    metavar="FACTOR",
    help="The greatest multiple of the scene's damping that is tried with its springs, before others are; 1 tries "
    "none.",
)
@click.option(
    "--damper-range",
    metavar="LEAST,MOST",
    help="Search dampers together with springs, of this damping of a hinge, N m s/rad.  [default: those of the scene]",
)
@click.option(
    "--damper-catalogue",
    metavar="C,C",
    help="With --catalogue: the damping of a hinge with each damper that can be bought, N m s/rad; each hinge gets "
    "none or one.",
)
@click.option(
    "--rule",
    metavar="ecss|aiaa|FILE.toml",
    help="Instead, choose least preloads, or springs of --offer, that pass the motorisation of a standard all along "
    "the travel.",
)
@click.option("--measured", is_flag=True, help="With --rule: friction and harness are measured values.")
@click.option(
    "--offer",
    "offers",
    multiple=True,
    metavar="LAW",
    help="With --rule: a spring that can be bought, such as linear:0.1+0.05; may be repeated.",
)
@click.option(
    "--evaluations",
    type=click.IntRange(min=1),
    default=TuningOptions.evaluations,
    show_default=True,
    help="How many sets of springs are tried at most, in all, each by one quick simulation.",
)
@click.option(
    "--samples",
    type=click.IntRange(min=0),
    default=TuningOptions.samples,
    show_default=True,
    help="How many simulations within the tolerances are run for each set that is reported; more compare sets.",
)
@click.option(
    "--spread",
    "spreads",
    multiple=True,
    metavar="NAME=SHARE",
    help="The tolerance of stiffness, damping, mass (default 0.05 each) or start (0.001); may be repeated.",
)
@click.option(
    "--spring-range",
    metavar="SOFT,STIFF",
    help="The softest and the stiffest spring, N m/rad.  [default: those of the scene]",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=TuningOptions.seed,
    show_default=True,
    help="Seed of the random numbers.",
)
@json_option
@click.option(
    "--output", metavar="FILE.toml", help="Write the scene with its springs to a file that hcsearch deploy reads."
)
def tune(name: str, as_json: bool, **options: Any) -> None:
    """Choose springs and dampers that open a folding without a collision.

    The springs of the scene with up to 10 times its damping are tried first. Where these open it in all samples within
    the tolerances, no other springs are searched.

    The search varies the stiffness of each hinge, with equal springs at mirror hinges and dampers in proportion (thesis
    4.4). In the scene default, stiffnesses are between 0.001 and 0.2 N m/rad. Of the sets with which the array becomes
    flat, certified free of collisions, it chooses the one that is least likely to fail within the tolerances. Every
    evaluation is stored in the database, so that the same command continues an interrupted search.

    With --rule it chooses springs by linear programs instead: the least preloads with which the torque of the springs
    passes the motorisation of a standard, with any one spring failed if the standard asks for it. Along a proved path a
    proved bound of it passes, between the states of the path, too; of a deployment the least at its simulated states.
    `hcsearch sheet` reviews the result.

    Exit code: 0 if the array becomes flat with the chosen springs, certified free of collisions; 1 if there are no such
    springs; 2 for wrong input.
    """
    from hcsearch.api import tuning as tunings

    if options["output"]:
        check_output(options["output"], (".toml",))
    catalogue, spread = _catalogue(options["catalogue"]), _spread(options["spreads"])
    damper_range = _damper_range(options["damper_range"])
    damper_catalogue = _catalogue(options["damper_catalogue"], "dampings in N m s/rad, such as 0.005,0.01")
    if options["rule"] is not None:
        _tune_to_rule(name, options, as_json=as_json)
        return
    if options["measured"] or options["offers"]:
        raise HcsearchError("--measured and --offer apply to a rule: add --rule ecss")
    case = resolve_named(name, options)
    with ProgressMeter("set") as meter:
        tuning = tunings.tune(
            case,
            keep_in=options["db"],
            catalogue=catalogue,
            spread=spread,
            progress=meter,
            damper_range=damper_range,
            damper_catalogue=damper_catalogue,
            **{name: options[name] for name in ("formulation", "evaluations", "samples", "seed", "most_damping")},
        )
    if options["output"]:
        if tuning.rounded is not None and not tuning.rounded.confirmed:
            click.echo(f"no catalogue springs are certified clear: {options['output']} has the tuned ones", err=True)
        write_output(options["output"], tunings.tuned_file_text(case, tuning))
    if as_json:
        click.echo(json.dumps(tuning.facts(), indent=2, allow_nan=False))
    else:
        _print(tuning, case)
    if tuning.interrupted:
        raise KeyboardInterrupt
    if not tuning.chosen.confirmed:
        click.get_current_context().exit(1)


def _tune_to_rule(name: str, options: dict[str, Any], *, as_json: bool) -> None:
    """Choose springs that pass a rule; write and print them."""
    from hcsearch.api import tuning as tunings

    if any(options[name] for name in ("catalogue", "spreads", "formulation", "damper_range", "damper_catalogue")):
        raise HcsearchError(
            "--rule chooses preloads or springs of --offer: leave out --catalogue, --spread, --formulation and dampers"
        )
    given = {option: options[option] for option in ("measured", "offers")}
    ruled = tunings.tune_to_rules(name, rules=options["rule"], **given, **case_options(options))
    if options["output"]:
        write_output(options["output"], ruled.file_text)
    facts = ruled.springs.facts()
    if as_json:
        click.echo(json.dumps({"motion": ruled.source, **facts}, indent=2, allow_nan=False))
        return
    failed = ", with any one spring failed" if facts["one_spring_failed"] else ""
    click.echo(f"{'motion':24}{ruled.source}")
    click.echo(f"{'torque margin':24}{facts['torque_margin']:.4g}, at least {facts['required']:g} is required{failed}")
    if facts["no_smaller_total_passes_N_m"] is not None:
        least = facts["no_smaller_total_passes_N_m"]
        click.echo(f"{'preloads':24}{facts['total_preload_N_m']:.4g} N m in all; below {least:.4g} N m none pass")
    wide = max(map(len, map(str, (*facts["hinges"], "hinge")))) + 2
    click.echo(f"\n{'hinge':{wide}}spring")
    for hinge, law in zip(facts["hinges"], facts["springs"], strict=True):
        click.echo(f"{hinge!s:{wide}}{law}")


def _catalogue(text: str | None, example: str = "stiffnesses in N m/rad, such as 0.07,0.10") -> tuple[float, ...]:
    if text is None:
        return ()
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise HcsearchError(f"{text!r} is no catalogue: write {example}") from error


def _damper_range(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise HcsearchError(f"{text!r} is no range of dampers: write N m s/rad, such as 0.001,0.02") from error
    return damper_bounds(values)


def _spread(texts: tuple[str, ...]) -> Spread:
    shares: dict[str, float] = {}
    twice = "--spread {} is given twice: leave one out"
    for text, name, share in named_numbers(texts, lambda name: HcsearchError(twice.format(name))):
        if name not in SPREAD_NAMES or share is None or not 0.0 <= share <= 0.5:
            names = ", ".join(SPREAD_NAMES)
            raise HcsearchError(f"{text!r} is no tolerance: write NAME=SHARE, a share from 0 to 0.5 of {names}")
        shares[name] = share
    return Spread(**shares)


def _print(tuning: Tuning, case: Case) -> None:
    labels, hinges = tuning.labels, case.linkage.pattern.hinges
    low, high = tuning.setup.spring_range
    click.echo(f"{'use':24}{tuning.advice}")
    if tuning.catalogue:
        click.echo(f"{'buy':24}{tuning.purchase}")
    click.echo(f"{'formulation':24}{tuning.formulation}")
    click.echo(f"{'springs, N m/rad':24}{low:g} to {high:g}")
    click.echo(f"{'seconds':24}{short_number(tuning.chosen.setup_in(tuning.setup).seconds, 6)}")
    click.echo(f"{'evaluations':24}{tuning.evaluations} sets of springs, {tuning.recalled} of them known before")
    click.echo(f"{'samples':24}{tuning.samples} simulations within the tolerances")
    damped = None
    if tuning.damped is not None:
        damped = tuning.damped.springs if tuning.damped.springs.confirmed else None
        if damped is None:
            click.echo(f"{'damped':24}{tuning.damped.sentence}")
    tuned = None if tuning.best is damped else tuning.best
    sets = [("start", tuning.start), ("damped", damped), ("tuned", tuned), ("catalogue", tuning.rounded)]
    shown = [(name, spring_set) for name, spring_set in sets if spring_set is not None]
    for name, spring_set in shown:
        factor = "" if tuning.damped is None or spring_set is not damped else f"{tuning.damped.factor:g} x damping: "
        click.echo(f"{name:24}{factor}{spring_set.sentence(labels)}")
    pairs = [f"{labels.panels[joint.first]}, {labels.panels[joint.second]}" for joint in hinges]
    wide = [max(map(len, (*column, "panels"))) + 2 for column in (labels.hinges, pairs)]
    tables = {"N m/rad": [spring_set.stiffnesses for _, spring_set in shown]}
    if any(spring_set.dampings or spring_set.damped for _, spring_set in shown):
        tables["N m s/rad"] = [spring_set.setup_in(tuning.setup).dampings for _, spring_set in shown]
    heads = "".join(f"{name:>12}" for name, _ in shown)
    for unit, columns in tables.items():
        click.echo(f"\n{'hinge':{wide[0]}}{'panels':{wide[1]}}{heads}  {unit}")
        for k, (hinge, panels) in enumerate(zip(labels.hinges, pairs, strict=True)):
            values = "".join(f"{column[k]:12.4g}" for column in columns)
            click.echo(f"{hinge:{wide[0]}}{panels:{wide[1]}}{values}")
