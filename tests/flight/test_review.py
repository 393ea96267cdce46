"""Flight sheets: each rule against its figure, sensitivities, springs that pass, and what a scene leaves out."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.scenes import SCENES, Scene
from hcsearch.shape.labels import labels_of
from hcsearch.springs.flight.flight_figures import figures_of, travel_margins
from hcsearch.springs.flight.flight_sheet import SHEET_STYLES, FlightSheet, SheetRow, sheet_text
from hcsearch.springs.flight.latching import arrival_loads
from hcsearch.springs.flight.review import review
from hcsearch.springs.flight.rules import Rule, Rules, read_rules
from hcsearch.springs.flight.spring_choice import springs_that_pass
from hcsearch.subjects.resolve import resolve

NAME = "hex:0234550132:4"
ECSS = read_rules("ecss")
BUILT = Scene(
    "built",
    spring="linear:0.1+0.02",
    friction=0.002,
    harness=0.001,
    latch_stiffness=100.0,
    stop_tolerance=1e-3,
    play=5e-4,
    thickness_tolerance=1e-5,
    offset_tolerance=1e-5,
    envelope="180x110x40",
    craft=((-0.02, -0.02, -0.1, 0.04, 0.04, 0.09),),
)


WITHOUT_TORQUE = replace(ECSS, given={key: ECSS.given[key] for key in ("latch", "clearance")})


def with_numbers(**numbers) -> Rules:
    """The rules of ECSS with other numbers of the motorisation."""
    rule = ECSS.given["motorisation"]
    return replace(ECSS, given=ECSS.given | {"motorisation": replace(rule, numbers=rule.numbers | numbers)})


def moved(scene, name=NAME):
    return resolve(name, scene=scene).travel()


def reviewed(scene, rules=ECSS, **options) -> FlightSheet:
    travel, _, source = moved(scene)
    return review(travel, rules, title=NAME, source=source, **options)


@pytest.fixture(scope="module")
def sheet():
    return reviewed(BUILT)


def row(sheet, name):
    (found,) = (one for one in sheet.rows if one.rule == name)
    return found


def test_a_row_passes_from_what_is_required_on():
    at_least = SheetRow("a", "1", 3.0, 3.0)
    assert (at_least.verdict, at_least.margin) == ("pass", 0.0)
    assert replace(at_least, figure=2.999).verdict == "fail"
    assert replace(at_least, figure=6.0).margin == 1.0
    at_most = SheetRow("a", "1", 3.0, 3.0, at_least=False)
    assert (at_most.verdict, replace(at_most, figure=3.1).verdict) == ("pass", "fail")
    assert replace(at_most, figure=1.5).margin == 0.5
    assert replace(at_least, figure=None).verdict == "not known"
    assert (replace(at_least, figure=None).margin, replace(at_least, required=0.0).margin) == (None, None)


def test_a_bound_and_a_sample_on_both_sides_of_a_rule_leave_it_not_known():
    bounded = SheetRow("a", "1", 2.5, 3.0, side="from below", other=3.5)
    assert (bounded.verdict, bounded.known) == ("not known", "proved, from below")
    assert replace(bounded, other=2.9).verdict == "fail"
    assert replace(bounded, figure=3.0).verdict == "pass"
    at_most = SheetRow("a", "1", 3.5, 3.0, at_least=False, side="from above", other=2.5)
    assert (at_most.verdict, replace(at_most, other=3.1).verdict) == ("not known", "fail")


def test_a_sampled_figure_does_not_pass():
    sampled = SheetRow("a", "1", 3.5, 3.0, kind="sampled", other=3.5)
    assert (sampled.verdict, sampled.known) == ("not known", "sampled")
    assert replace(sampled, figure=2.9, other=2.9).verdict == "fail"
    assert replace(sampled, kind="simulated").verdict == "pass"
    assert replace(sampled, figure=None).known == "-"


def test_latches_bear_the_simulated_arrivals_and_at_most_all_energy(sheet):
    arriving, most = sheet.demands[:2]
    assert (arriving.known, most.known) == ("simulated", "proved, from above")
    strengths = [float(demand.value.removesuffix(" N m")) for demand in (arriving, most)]
    assert strengths[1] == pytest.approx(2.0 * sheet.numbers["latch_torque"], rel=1e-3)
    travel = sheet.travel
    loads = arrival_loads(travel.deployment, np.array(travel.setup.latch_stiffness))
    assert strengths[0] == pytest.approx(2.0 * max(np.nanmax(load.torques) for load in loads), rel=1e-3)
    assert 0.0 < strengths[0] < 0.5 * strengths[1]
    along_path = replace(travel, deployment=None, source="path")
    alone = review(along_path, WITHOUT_TORQUE, title="", source="").demands
    assert [demand.what for demand in alone if "latch" in demand.what] == [most.what]


def test_dampers_are_listed_with_the_torque_of_the_fastest():
    plain = reviewed(Scene("plain", friction=0.001))
    assert plain.dampers == ()
    assert not [demand for demand in plain.demands if "damper" in demand.what]
    assert "dampers" not in sheet_text(plain, "text") + " ".join(plain.omitted)
    own = (("2", (("damping", 0.02),)), ("3", (("damping", 0.005),)))
    damped = reviewed(Scene("damped", friction=0.001, hinges=own))
    assert damped.dampers == ((0.005, ("3",)), (0.02, ("2",)))
    assert damped.facts()["dampers"][1] == {"damping_N_m_s_rad": 0.02, "hinges": ["2"]}
    assert "0.005 N m s/rad at hinge 3; 0.02 N m s/rad at hinge 2" in sheet_text(damped, "text")
    assert any(sentence.startswith("dampers in the torque of springs") for sentence in damped.omitted)
    sheet = reviewed(replace(BUILT, name="all", damping=0.006))
    ((damping, hinges),) = sheet.dampers
    assert (damping, len(hinges)) == (0.006, sheet.travel.linkage.n_hinges)
    (demand,) = [demand for demand in sheet.demands if "damper" in demand.what]
    value, hinge = demand.value.split(" N m at hinge ")
    torques = 0.006 * np.abs(sheet.travel.deployment.rates).max(axis=0)
    assert float(value) == pytest.approx(torques.max(), rel=1e-3)
    assert labels_of(sheet.travel.linkage).hinge(hinge) == torques.argmax()


def test_springs_without_preload_are_named_on_top():
    weak = reviewed(Scene("weak", friction=0.001))
    assert weak.advice == "springs without preload cannot pass; these would, along the same motion"
    assert len(weak.springs) == 8
    for style in SHEET_STYLES:
        text = sheet_text(weak, style)
        assert 0 < text.index("Springs without preload cannot pass") < text.index("torque of springs over resistance")
    strong = reviewed(Scene("strong", spring="linear:0.1+0.02", friction=0.001))
    assert (strong.advice, strong.springs) == ("", ())


def test_a_sheet_passes_where_all_rows_do():
    passes, fails, unknown = (SheetRow("a", "1", figure, 1.0) for figure in (2.0, 0.5, None))
    for rows, verdict in (
        ((passes,), "pass"),
        ((passes, unknown), "not known"),
        ((unknown, fails), "fail"),
        ((), "pass"),
    ):
        assert FlightSheet("a", "b", "c", "d", rows, (), {}).verdict == verdict


def test_rules_are_held_against_the_figures(sheet):
    numbers = sheet.numbers
    torque = row(sheet, "torque of springs over resistance")
    # friction and harness count alike in this standard, so the figure is that of the columns
    assert torque.figure == numbers["torque_margin"]
    assert 0.98 * 0.02 / 0.003 < torque.figure <= 0.02 / 0.003 * (1.0 + 1e-9)  # bounded between the steps
    assert (torque.clause, torque.required, torque.verdict) == ("4.7.5.3.1", 7.5, "fail")
    assert "least at 100 % of the travel" in torque.note
    failed = row(sheet, "the same, one spring failed")
    assert failed.figure == numbers["torque_margin_failed"] < torque.figure
    clearance = row(sheet, "clearance over tolerances")
    assert clearance.figure == numbers["clearance_ratio"] > 0.0
    room = row(sheet, "room in the envelope")
    assert room.figure == pytest.approx(180.0 - 100.0 * math.sqrt(3.0), abs=1e-5)
    assert room.verdict == "pass"
    demands = {demand.what: demand.value for demand in sheet.demands}
    (stacks,) = (value for what, value in demands.items() if what.startswith("stacks that stand in"))
    assert re.fullmatch(r"panels [\d.]+ mm thick, or \d+ layers of these", stacks)
    for style in SHEET_STYLES:
        assert all(value in sheet_text(sheet, style) for value in demands.values())
    assert row(sheet, "gap to the craft").figure == pytest.approx(1e3 * numbers["craft_clearance"])
    assert sheet.verdict == "fail"
    assert sheet.source.startswith("springs, flat after")


def test_a_sheet_says_why_springs_do_not_open_a_folding():
    source = moved(SCENES["default"], "hex:02234400:1").source
    assert source.startswith("springs do not open it (panels 4 and 7 collide at 0.01282 s); a proved path")


def test_springs_that_pass_are_named_where_those_of_the_scene_fail(sheet):
    assert len(sheet.springs) == len(dict(sheet.springs)) == 8
    tuned = replace(sheet, springs=(("0", "linear:0.0437281928374651+0.0123"),))
    for style in SHEET_STYLES:
        assert "spring that passes" in sheet_text(sheet, style)
        assert sheet_text(sheet, style).index(
            "The springs of the scene do not pass; these would, along the same motion."
        ) < (sheet_text(sheet, style).index("torque of springs over resistance"))
        assert " linear:0.0437282+0.0123" in sheet_text(tuned, style)
    assert reviewed(BUILT, WITHOUT_TORQUE).springs == ()
    assert reviewed(BUILT, with_numbers(overall=0.1)).springs == ()


def test_measured_resistance_has_smaller_factors(sheet):
    measured = reviewed(BUILT, measured=True)
    assert row(measured, "torque of springs over resistance").required == 3.75
    assert row(measured, "torque of springs over resistance").verdict == "pass"
    assert measured.numbers == sheet.numbers


def test_a_harness_may_count_more_than_friction():
    own = reviewed(BUILT, with_numbers(harness=6.0))
    # at flat each hinge has its preload against its friction and twice its harness
    assert 0.98 * 0.02 / 0.004 < row(own, "torque of springs over resistance").figure <= 0.02 / 0.004 * (1.0 + 1e-9)


def test_own_rules_on_frequency_and_flatness_are_judged():
    own_rules = {"frequency": Rule("3", {"hz": 0.1}), "flatness": Rule("4", {"mm": 0.5})}
    own = reviewed(BUILT, replace(ECSS, given=ECSS.given | own_rules))
    flat = row(own, "flatness as built")
    assert (flat.unit, flat.required, flat.at_least) == ("mm", 0.5, False)
    assert flat.figure >= 1.5 * own.numbers["flatness_mm_per_mrad"]  # stops and play alone are 1.5 mrad off
    frequency = row(own, "deployed frequency")
    assert (frequency.figure, frequency.required) == (own.numbers["deployed_hz"], 0.1)


def test_the_scene_default_has_no_margin_when_flat():
    """Linear springs without preload drive nothing there, whatever the friction."""
    default = reviewed(SCENES["default"])
    torque = row(default, "torque of springs over resistance")
    assert (torque.figure, torque.verdict) == (0.0, "fail")
    assert default.numbers["torque_margin"] == 0.0
    assert default.numbers["torque_margin_at"] == 1.0
    assert row(default, "clearance over tolerances").verdict == "not known"
    left_out = " ".join(default.omitted)
    for what in ("clearance over tolerances", "gaps to the craft", "torque of latches", "gravity"):
        assert what in left_out


def test_where_nothing_resists_the_margin_is_not_known():
    preloaded = reviewed(replace(BUILT, friction=0.0, harness=0.0))
    torque = row(preloaded, "torque of springs over resistance")
    assert (torque.figure, torque.verdict, torque.note) == (None, "not known", "no friction and no harness given")
    assert preloaded.numbers["torque_margin"] is None
    assert preloaded.margins == ()


def test_margins_follow_springs_and_friction_in_the_sensitivities(sheet):
    rows = {(one.value, one.figure): one for one in sheet.sensitivities}
    margin = sheet.numbers["torque_margin"]
    springs = rows["torque of springs", "torque margin"]
    assert (springs.low, springs.high) == pytest.approx((0.8 * margin, 1.2 * margin))
    friction = rows["friction", "torque margin"]
    for figure, exact in ((friction.low, 0.02 / 0.0026), (friction.high, 0.02 / 0.0034)):  # bounded between the steps
        assert 0.98 * exact < figure <= exact * (1.0 + 1e-9)
    assert [one.spread for one in sheet.sensitivities] == sorted(
        (one.spread for one in sheet.sensitivities), reverse=True
    )
    assert all(one.spread > 0.0 for one in sheet.sensitivities)


def test_the_margin_is_drawn_along_the_whole_travel(sheet):
    places, margins = np.array(sheet.margins).T
    assert (places[0], places[-1]) == (0.0, 1.0)
    assert (np.diff(places) > 0.0).all()
    assert 0.99 * margins.min() < sheet.numbers["torque_margin"] <= margins.min()  # at states, and bounded between them


@pytest.mark.parametrize("style", SHEET_STYLES)
def test_texts_have_every_rule(sheet, style):
    text = sheet_text(sheet, style)
    for one in sheet.rows:
        assert one.rule in text
        assert one.clause in text
    assert "4.7.5.3.2 f" in text
    assert ("\\toprule" in text) == (style == "latex")
    assert text.endswith("\n")


def test_marks_of_markdown_and_latex_are_escaped(sheet):
    marked = replace(sheet, title="a|b_c%d&e")
    assert "a\\|b_c%d&e" in sheet_text(marked, "markdown")
    assert "a|b\\_c\\%d\\&e" in sheet_text(marked, "latex")


def test_facts_are_plain_data(sheet):
    facts = json.loads(json.dumps(sheet.facts(), allow_nan=False))
    assert facts["verdict"] == "fail"
    assert [one["rule"] for one in facts["rules"]] == [one.rule for one in sheet.rows]
    assert facts["figures"]["stowed_height"] == pytest.approx(30.0)


def test_chosen_preloads_pass_with_any_one_spring_failed():
    travel, _, _ = moved(BUILT)
    chosen = springs_that_pass(travel, ECSS)
    assert chosen.margin >= chosen.required == 7.5
    assert chosen.lower_bound <= chosen.preloads.sum() * (1.0 + 1e-9)
    assert (chosen.preloads >= 0.0).all()
    margins = travel_margins(replace(travel, setup=chosen.setup))
    assert min(margins.margins.min(), margins.failed.min()) >= 7.5 * (1.0 - 1e-9)
    weaker = springs_that_pass(travel, replace(ECSS, given={"motorisation": ECSS.given["motorisation"]}))
    assert weaker.preloads.sum() < chosen.preloads.sum()
    assert not weaker.redundant


@pytest.mark.parametrize("name", ["hex:023444401021:3", "hex:023454401022:0"])
def test_chosen_springs_pass_at_singular_ends_as_a_sheet_finds_their_motions(name):
    """With the motions of other rounds of the design the sheet would not pass."""
    travel, _, source = moved(replace(BUILT, craft=(), margin=5e-4), name)
    with_them = replace(travel, setup=springs_that_pass(travel, ECSS).setup)
    rows = review(with_them, ECSS, title=name, source=source).rows[:2]
    assert [one.verdict for one in rows] == ["pass", "pass"]


def test_offered_springs_are_chosen_where_they_pass():
    travel, _, _ = moved(BUILT)
    offers = ["linear:0.1+0.05", "linear:0.05+0.1"]
    chosen = springs_that_pass(travel, ECSS, offers=offers)
    assert {law.text for law in chosen.setup.laws} <= {"free", *offers}
    assert chosen.margin >= 7.5
    assert chosen.lower_bound is None
    with pytest.raises(HcsearchError, match=r"no springs|none"):
        springs_that_pass(travel, ECSS, offers=["linear:0.1"])


def test_springs_are_chosen_only_against_what_resists():
    travel, _, _ = moved(SCENES["default"])
    with pytest.raises(HcsearchError, match="nothing resists the springs: give friction or harness"):
        springs_that_pass(travel, ECSS)
    with pytest.raises(HcsearchError, match="asks for no torque of springs"):
        springs_that_pass(travel, WITHOUT_TORQUE)


def test_a_path_is_the_travel_where_springs_do_not_open_it():
    travel, scene, source = moved(SCENES["default"], "hex:0234435011:1")
    assert travel.source == "path"
    assert "a proved path" in source
    assert scene.flat_pairs == ("hinged",)
    assert travel.shares[0] == 0.0
    numbers = figures_of(travel)
    assert numbers["torque_margin"] == 0.0


def test_springs_that_push_against_a_proved_path_are_named():
    travel, _, source = moved(BUILT, "square:012122333001:1")
    guided = travel_margins(travel).along
    assert travel.source == "path"
    assert guided.min() < 0.0 < travel_margins(travel).margins.min()
    found = row(review(travel, ECSS, title="", source=source), "torque of springs over resistance")
    assert f"guided along the path {guided.min():.3g}" in found.note


def test_figures_do_not_depend_on_how_a_circuit_is_written():
    """The same folding from another panel on."""
    later = next(one for one in foldings(Circuit.from_notation("hex:3455013202")) if one.crease == 2)
    assert later != Folding.from_notation(NAME)
    figures = [figures_of(moved(BUILT, name).travel) for name in (NAME, later)]
    names = ("torque_margin", "torque_margin_failed", "flatness_mm_per_mrad", "tilt", "clearance_ratio", "mass")
    for name in (*names, "stowed_length"):
        first, second = (one[name] for one in figures)
        assert first == pytest.approx(second, rel=1e-9), name
    assert figures[0]["self_stresses"] == figures[1]["self_stresses"]
