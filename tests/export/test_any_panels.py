"""Patterns of any convex panels: read, packed, checked and exported as linkages."""

import json
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch import check, deploy, drive, replay, save
from hcsearch.api.driving import DriveOptions
from hcsearch.basics.errors import HcsearchError, PatternError
from hcsearch.designs.circuit import Circuit
from hcsearch.export.fold import fold_of
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.motion.collision.distances import cuts_through
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.scenes import Scene
from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.search.own_patterns.drawn_linkages import pattern_of_drawing
from hcsearch.search.own_patterns.fold_reading import parse_fold, read_fold
from hcsearch.search.own_patterns.packed_states import _PackingSearch, pack_drawing
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.pattern_files import DrawnDesign, read_pattern_file
from hcsearch.subjects.resolve import resolve
from hcsearch.system.work_steps import hearing_work
from tests.commands import run_here


def drawing_of(polygons, marks, **keys):
    """A FOLD file as data. marks : a letter, or a letter and a fold angle, for pairs of faces; others have slits."""
    points, faces = [], []
    for polygon in polygons:
        for point in polygon:
            if point not in points:
                points.append(point)
        faces.append([points.index(point) for point in polygon])
    sides = {}
    for f, face in enumerate(faces):
        for a, b in zip(face, [*face[1:], *face[:1]], strict=True):
            sides.setdefault((min(a, b), max(a, b)), []).append(f)
    letters = [marks.get(tuple(beside), "C") if len(beside) == 2 else "B" for beside in sides.values()]
    data = {
        "vertices_coords": [list(point) for point in points],
        "edges_vertices": [list(side) for side in sides],
        "faces_vertices": faces,
        "edges_assignment": [letter[0] for letter in letters],
    }
    if any(not isinstance(letter, str) for letter in letters):
        data["edges_foldAngle"] = [0 if isinstance(letter, str) else letter[1] for letter in letters]
    return data | keys


def strip(widths, letters, lean=0.2):
    """A strip of trapezoids, in a row."""
    places = np.cumsum([0.0, *widths]).tolist()
    tops = [place + (lean if k % 2 else -lean) for k, place in enumerate(places)]
    polygons = [
        [(places[k], 0.0), (places[k + 1], 0.0), (tops[k + 1], 2.0), (tops[k], 2.0)] for k in range(len(widths))
    ]
    return drawing_of(polygons, {(k, k + 1): letter for k, letter in enumerate(letters)})


def packed_of(data, panel=None):
    return pack_drawing(parse_fold(json.dumps(data)), panel)


def written(tmp_path, data):
    path = tmp_path / "own.fold"
    path.write_text(json.dumps(data))
    return str(path)


def test_edges_within_a_panel_do_not_count_as_its_longest_edge(tmp_path):
    square = [(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)]
    halves = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], [(0.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    path = written(tmp_path, drawing_of([*halves, square], {(0, 1): "F", (0, 2): "M"}))
    assert check(path, panel="100x6", seconds=0.01).facts["longest_edge_mm"] == pytest.approx(100.0)
    outline = np.array(resolve(path, panel="100x6").linkage.pattern.vertices)
    assert np.ptp(outline, axis=0) == pytest.approx([0.2, 0.1])


@pytest.mark.parametrize("name", ["element-8r", "unit-ii", "module-i", "array-6r"])
def test_an_exported_assembly_is_read_back_with_its_mobility_at_both_ends(name):
    assembly = ASSEMBLIES[name]
    linkage = Linkage(assembly.build(assembly.defaults))
    data = json.loads(fold_of(name, linkage, labels_of(linkage)))
    packed = packed_of(data)
    again = Linkage(packed.pattern)
    assert packed.packed
    assert (again.n_panels, again.n_hinges, again.loops) == (linkage.n_panels, linkage.n_hinges, linkage.loops)
    assert np.array_equal(again.folded, linkage.folded)
    for ours, theirs in ((again.folded, linkage.folded), (again.flat, linkage.flat)):
        assert rank_at(again, ours).nullity == rank_at(linkage, theirs).nullity
    unassigned = data | {"edges_assignment": ["U" if mark in "MV" else mark for mark in data["edges_assignment"]]}
    del unassigned["edges_foldAngle"], unassigned["edges_hcsearch:hingeFace"]
    found = Linkage(packed_of(unassigned).pattern)
    assert np.abs(found.closure(found.folded)[0]).max() < 1e-12
    assert not cuts_through(found, found.folded[None])


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_a_rounded_drawing_is_moved_by_less_than_its_error_so_that_its_packed_state_closes(seed):
    assembly = ASSEMBLIES["element-8r"]
    linkage = Linkage(assembly.build(assembly.defaults))
    data = json.loads(fold_of("8R", linkage, labels_of(linkage)))
    errors = np.random.default_rng(seed).uniform(-0.005, 0.005, (len(data["vertices_coords"]), 2))
    data["vertices_coords"] = (np.array(data["vertices_coords"]) + errors).tolist()
    packed = packed_of(data)
    rounded = Linkage(packed.pattern)
    assert packed.packed
    assert np.abs(rounded.closure(rounded.folded)[0]).max() < 1e-10
    assert 0.0 < packed.moved < 3e-5


@given(st.lists(st.floats(1.0, 3.0), min_size=2, max_size=7))
@settings(max_examples=20)
def test_strips_without_assignments_are_packed_in_layers_that_keep_apart(widths):
    packed = packed_of(strip(widths, ["U"] * (len(widths) - 1)))
    linkage = Linkage(packed.pattern)
    assert packed.packed
    assert linkage.folded.all()
    assert not cuts_through(linkage, linkage.folded[None])


@given(st.lists(st.tuples(st.sampled_from([1.0, 1.5, 2.25, 3.0]), st.sampled_from("MV")), min_size=2, max_size=7))
@settings(max_examples=30)
def test_a_strip_with_mountains_and_valleys_is_packed_just_where_its_panels_keep_apart(panels):
    widths, letters = [1.5, *(width for width, _ in panels)], [letter for _, letter in panels]
    packed = packed_of(strip(widths, letters))
    linkage = Linkage(packed.pattern)
    all_closed = np.full(linkage.n_hinges, math.pi)
    assert [hinge.face for hinge in packed.pattern.hinges] == [
        "top" if letter == "V" else "bottom" for letter in letters
    ]
    assert packed.packed == (not cuts_through(linkage, all_closed[None]))


def test_an_accordion_deploys_and_a_roll_has_no_packed_state(tmp_path):
    (accordion,) = check(written(tmp_path, strip([2.0, 1.5, 1.8], "MV"))).verdicts
    assert (accordion.status, accordion.dof, accordion.linkage.pattern.kutzbach) == ("deploys", 2, 2)
    assert accordion.facts()["longest_edge_mm"] == 50.0
    (roll,) = check(written(tmp_path, strip([2.0, 2.0, 2.0, 2.0], "VVV"))).verdicts
    assert (roll.status, roll.dof, roll.deployment) == (None, 3, None)
    assert "share a layer" in roll.reasons[0]


def test_many_panels_bound_the_search_for_a_packed_state_which_is_named():
    squares = [[(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)] for x in range(12) for y in range(12)]
    sides = {(k, m): "M" if m == k + 1 else "V" for k in range(144) for m in (k + 1, k + 12)}
    drawing = parse_fold(json.dumps(drawing_of(squares, sides)))
    search, heard = _PackingSearch(drawing, pattern_of_drawing(drawing, None)), []
    assert len(list(search._flat_sets())) == 1 + 964
    with hearing_work(lambda words, count: heard.append(words)):
        search.packed()
    assert heard == ["searching for a packed state"]


def test_stated_fold_angles_say_which_hinges_stay_flat_or_partly_closed(tmp_path):
    widths = [2.0, 1.5, 1.8]
    flat = packed_of(strip(widths, [("M", -180), ("V", 0)]))
    assert [hinge.closes for hinge in flat.pattern.hinges] == [True, False]
    box = strip(widths, [("M", -90), ("V", 45)])
    partly = packed_of(box)
    assert partly.packed
    assert [hinge.folded_angle for hinge in partly.pattern.hinges] == pytest.approx([math.pi / 2, math.pi / 4])
    assert check(written(tmp_path, box)).verdicts[0].dof_packed == 2


def test_a_state_with_all_hinges_flat_is_no_packed_state():
    packed = packed_of(strip([2.0, 1.5], "F") | {"edges_hcsearch:hingeFace": ["top"] * 7})
    assert not packed.packed
    assert "the file keeps all hinges flat" in packed.sentence


def test_a_hinge_along_a_part_of_a_side_is_read():
    polygons = [
        [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (0.0, 2.0)],
        [(0.0, 2.0), (2.0, 2.0), (1.8, 4.0), (0.2, 4.0)],
        [(2.0, 2.0), (4.0, 2.0), (3.8, 4.0), (2.2, 4.0)],
    ]
    packed = packed_of(drawing_of(polygons, {(0, 1): "M", (0, 2): "V"}))
    assert packed.packed
    hinges = {(hinge.first, hinge.second, hinge.face) for hinge in packed.pattern.hinges}
    assert hinges == {(0, 1, "bottom"), (0, 2, "top")}


def test_a_longest_edge_on_which_other_panels_end_has_the_length_that_is_asked_for(tmp_path):
    polygons = [
        [(0.5, 0.0), (3.5, 0.0), (4.0, 2.0), (2.0, 2.0), (0.0, 2.0)],
        [(0.0, 2.0), (2.0, 2.0), (1.8, 4.0), (0.2, 4.0)],
        [(2.0, 2.0), (4.0, 2.0), (3.8, 4.0), (2.2, 4.0)],
    ]
    path = written(tmp_path, drawing_of(polygons, {(0, 1): "M", (0, 2): "V"}))
    assert check(path, panel="80x8").facts["longest_edge_mm"] == pytest.approx(80.0)


_SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
_LEFT = [(-1.0, 0.2), (0.0, 0.0), (0.0, 1.0), (-1.0, 0.9)]
_RIGHT = [(1.0, 0.0), (2.0, 0.1), (2.0, 0.9), (1.0, 1.0)]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            drawing_of([_SQUARE, [(1.0, 0.0), (2.0, -1.0), (1.3, 0.5), (2.0, 2.0), (1.0, 1.0)]], {(0, 1): "M"}),
            "panel 1 at .* is not convex, at its corner 2: divide it",
        ),
        (drawing_of([_LEFT, _SQUARE, _RIGHT], {(0, 1): "M"}), r"panel 2 at .* is joined to none of the 2 panels"),
        (drawing_of([_LEFT], {}), "one panel and no crease"),
        (drawing_of([_LEFT, _SQUARE], {(0, 1): "F"}), "all panels of the drawing are one"),
        (drawing_of([_LEFT, _SQUARE, [(1.0, 0.0), (0.5, 0.5), (1.0, 1.0)]], {(0, 1): "M", (1, 2): "M"}), "overlap"),
        (
            drawing_of([_LEFT, _SQUARE], {(0, 1): "M"}, **{"edges_hcsearch:hingeFace": ["top"] * 7}),
            "M with its hinge on the top face",
        ),
        (
            drawing_of([_LEFT, _SQUARE], {(0, 1): "M"}, **{"hcsearch:loops": [[[0, 5]]]}),
            "loop 0 in hcsearch:loops is no ring of panels",
        ),
        (
            drawing_of([_LEFT, _SQUARE], {(0, 1): "M"}, **{"hcsearch:thickness": 1e-300}),
            "the longest edge is 50 mm and the thickness .* mm: take lengths from",
        ),
        (
            drawing_of([_LEFT, _SQUARE, _RIGHT], {(0, 1): ("M", -40), (1, 2): ("U", 0)}),
            r"is unassigned \(U\), and the file states a state with",
        ),
    ],
)
def test_what_is_no_linkage_of_panels_is_refused_in_one_line(data, message, tmp_path, capfd):
    result = run_here(["check", written(tmp_path, data)], capfd)
    assert (result.returncode, result.stdout) == (2, "")
    assert len(result.stderr.strip().splitlines()) == 1
    assert re.search(message, result.stderr)


def test_commands_take_a_drawn_pattern_as_their_subject(tmp_path, capfd):
    path = written(tmp_path, strip([2.0, 1.5, 1.8], "MV"))
    result = run_here(["check", path, "--panel", "80x4", "--json"], capfd)
    facts = json.loads(result.stdout)
    assert (result.returncode, facts["status"], facts["longest_edge_mm"], facts["thickness_mm"]) == (
        0,
        "deploys",
        80.0,
        4.0,
    )
    assert "is no design of a grid, as panel 0" in result.stderr
    assert deploy(path).verdict == "deploys"
    assert replay(path, motion="path").ends_flat
    driven = drive(path, options=DriveOptions(rate=3.0))
    assert (driven.title, driven.facts()["freedoms"], driven.deployment.verdict) == (path, 2, "deploys")
    springs = tmp_path / "springs.toml"
    springs.write_text(
        scene_file_text(resolve(path, panel="80x4").entries, None, Scene(name="stiff", spring="linear:0.3"))
    )
    case = resolve(str(springs))
    assert (case.linkage.pattern.thickness, case.scene.spring) == (0.004, "linear:0.3")
    result = run_here(["deploy", path, "--flat-pairs", "hinged"], capfd)
    assert (result.returncode, len(result.stderr.splitlines())) == (2, 1)


def test_a_pattern_without_a_packed_state_is_only_checked_and_followed_from_flat(tmp_path, capfd):
    path = written(tmp_path, strip([2.0, 2.0, 2.0, 2.0], "VVV"))
    for start in (["--from", "flat"], ["--angles", "0.1,0.2,0.3"]):
        followed = run_here(["motion", path, *start], capfd)
        assert followed.returncode == 0
        assert re.search(r"arc length 0[.][1-9]|arc length [1-9]", followed.stdout.splitlines()[-1])
        assert f"{path}: no packed state is known: " in followed.stderr
    for asked in ([], ["--from", "folded"], ["--from", "flat", "--until", "folded"]):
        result = run_here(["motion", path, *asked], capfd)
        assert (result.returncode, len(result.stderr.splitlines())) == (2, 1)
        assert re.search("no packed state is known: .*, or follow .* by hcsearch motion --from flat$", result.stderr)
    assert "degrees of freedom: 3 during the motion, - packed, 3 flat" in run_here(["check", path], capfd).stdout
    with pytest.raises(HcsearchError, match=f"no packed state is known: .*; see hcsearch check {re.escape(path)}"):
        resolve(path)


def test_a_file_that_draws_a_folding_stands_for_it(tmp_path):
    path = str(tmp_path / "design.fold")
    save("hex:0234550132:4", path)
    case = resolve(path, "none.sqlite")
    assert (case.title, case.panel) == ("hex:0234550132:4", (0.05, 0.05, 0.006))


@pytest.mark.parametrize("ending", [".fold", ".glb", ".step", ".xml", ".urdf", ".svg"])
def test_drawn_patterns_are_exported(ending, tmp_path):
    path = written(tmp_path, strip([2.0, 1.5, 1.8], "MV"))
    main, *_ = save(path, tmp_path / f"out{ending}")
    assert main.stat().st_size > 500
    if ending == ".fold":
        read, given = pack_drawing(read_fold(str(main))).pattern, resolve(path).linkage.pattern
        assert (read.faces, read.creases) == (given.faces, given.creases)
        assert np.allclose(read.vertices, given.vertices, rtol=0.0, atol=1e-12)


def test_a_scene_file_names_a_pattern_in_its_own_folder(tmp_path):
    save("unit-ii", tmp_path / "u.fold")
    (tmp_path / "case.toml").write_text("pattern = 'u.fold'\n", encoding="utf-8")
    case = resolve(str(tmp_path / "case.toml"))
    assert case.linkage.n_hinges == resolve("unit-ii").linkage.n_hinges
    assert case.entries["pattern"] == str(tmp_path / "u.fold")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("pattern = 'unit-ii'", "write assembly = 'unit-ii'"),
        ("pattern = 'hex:0234550132:4'", "write design = 'hex:0234550132:4'"),
        ("pattern = 'unit'", "name a file .fold, .cp, .opx, .svg, .urdf, .xml, .mjcf"),
        ("design = 'u.fold'", "write pattern = 'u.fold'"),
        ("assembly = '17:4'", "write design = '17:4'"),
        ("assembly = 'unit-9'", "there is no assembly 'unit-9'"),
    ],
)
def test_each_key_of_a_scene_file_names_its_own_kind(line, message, tmp_path):
    (tmp_path / "case.toml").write_text(line)
    with pytest.raises(HcsearchError, match=message):
        resolve(str(tmp_path / "case.toml"), "none.sqlite")


def test_a_scene_file_is_checked_with_its_pattern_and_its_springs(tmp_path):
    written(tmp_path, strip([2.0, 1.5, 1.8], "MV"))
    (tmp_path / "case.toml").write_text("name = 'stiff'\npattern = 'own.fold'\nscene.spring = 'linear:0.3'\n")
    checked = check(str(tmp_path / "case.toml"), db="none.sqlite")
    assert (checked.verdicts[0].status, checked.scene.name, checked.scene.spring) == ("deploys", "stiff", "linear:0.3")


@pytest.mark.parametrize("panel", ["0x0", "50", "50x40x6", "across 50x6", "1e9x6"])
def test_a_size_that_no_pattern_has_is_refused_with_the_sizes_of_one(panel):
    with pytest.raises(PatternError, match="write its longest edge x the thickness, each from"):
        packed_of(strip([1.0, 1.0], "M"), panel)


@pytest.mark.parametrize(("angle", "letter"), [(180, "V"), (-180, "M"), (30, "V"), (-90, "M")])
def test_the_sign_of_an_angle_of_an_unassigned_crease_is_its_assignment(angle, letter):
    (join,) = parse_fold(json.dumps(strip([1.0, 1.0], [("U", angle)])), "a.fold").joins.values()
    assert join.assignment == letter


FOUR_STACKS = {
    "square:012233300121": "0MVMV0VM0VM0",  # which also folds into two stacks
    "square:012232230001": "M00V0VMVM0MV",  # which does not
}
"""The creases of foldings of twelve squares into four stacks, in the order of the circuit; 0 stays flat, on top."""
RING_OF_EIGHT = "square:01122330"


def drawn_circuit(notation, creases, flat=("V", 0)):
    """A circuit drawn with its creases: mountains, valleys, and 0 for those that stay flat."""
    circuit = Circuit.from_notation(notation)
    polygons = [[tuple(corner) for corner in circuit.grid.corners(cell)] for cell in circuit.cells]
    marks = {"M": ("M", -180), "V": ("V", 180), "0": flat, "m": "M", "v": "V", "u": "U", "f": "F"}
    pairs = [tuple(sorted((k, (k + 1) % circuit.n))) for k in range(circuit.n)]
    return drawing_of(polygons, dict(zip(pairs, (marks[crease] for crease in creases), strict=True)))


@pytest.mark.parametrize("flat", [("V", 0), ("M", 0), ("U", 0)])
@pytest.mark.parametrize("notation", FOUR_STACKS)
def test_a_stated_folding_into_four_stacks_is_a_linkage_in_this_state(notation, flat, tmp_path):
    path = written(tmp_path, drawn_circuit(notation, FOUR_STACKS[notation], flat))
    drawn = read_pattern_file(path)
    why = "has no two-stack folding" if notation.endswith("0001") else "are of no two-stack folding of the circuit"
    assert why in drawn.no_design
    assert drawn.packed.sentence == "packed state stated by the file: 4 of 12 hinges flat, the others closed"
    linkage = Linkage(drawn.packed.pattern)
    middles = [solid.reshape(-1, 3).mean(axis=0)[:2] for solid in linkage.solids(linkage.folded)]
    assert len(np.unique(np.round(middles, 6) + 0.0, axis=0)) == 4


def test_a_stated_state_is_judged_though_the_letters_are_those_of_a_two_stack_folding(tmp_path):
    save("square:01222300:1", tmp_path / "a.fold")
    data = json.loads((tmp_path / "a.fold").read_text())
    del data["edges_hcsearch:hingeFace"], data["file_frames"]
    flat = [k for k, angle in enumerate(data["edges_foldAngle"][:8]) if angle == 0]
    letters = ["U" if k in flat else "M" if angle < 0 else "V" for k, angle in enumerate(data["edges_foldAngle"][:8])]
    data["edges_assignment"] = [*letters, *["B"] * (len(data["edges_vertices"]) - 8)]
    assert isinstance(read_pattern_file(written(tmp_path, data)), DrawnDesign)
    for k in flat:
        data["edges_foldAngle"][k] = 180
    assert "or the fold angles, are of no two-stack folding" in read_pattern_file(written(tmp_path, data)).no_design


@pytest.mark.slow
def test_a_ring_of_eight_squares_is_judged_by_all_commands(tmp_path, capfd):
    path = written(tmp_path, drawn_circuit(RING_OF_EIGHT, "mvmvmvmv"))
    note = f"{path} is taken as a linkage, as {RING_OF_EIGHT} has no two-stack folding"
    results = {}
    for words in (
        ["check", path, "--json"],
        ["show", path],
        ["motion", path],
        ["motion", path, "--from", "flat"],
        ["prove", path, "--output", str(tmp_path / "lock.json")],
        ["show", path, "--html", "--output", str(tmp_path / "ring.html")],
    ):
        result = results[" ".join(words[:1] + words[2:3])] = run_here(words, capfd)
        assert result.stderr.splitlines()[0] == note
        assert len(result.stderr.splitlines()) == 1
    facts = json.loads(results["check --json"].stdout)
    assert (facts["status"], facts["dof"], facts["dof_flat"], facts["kutzbach"]) == ("locked", 0, 3, 2)
    assert "lock at flat         locked (exact proof)" in results["show"].stdout
    assert "no finite motion was found at the start" in results["motion --from"].stdout
    assert run_here(["verify", str(tmp_path / "lock.json")], capfd).returncode == 0


def test_an_unassigned_drawing_of_a_circuit_without_foldings_is_a_linkage(tmp_path, capfd):
    path = written(tmp_path, drawn_circuit("hex:012345", "uuuuuu"))
    assert read_pattern_file(path).no_design == "is taken as a linkage, as hex:012345 has no two-stack folding"
    result = run_here(["check", path], capfd)
    assert (result.returncode, "status: deploys" in result.stdout) == (0, True)
    assert "nothing folds" not in result.stderr


@pytest.mark.parametrize(
    ("creases", "note"),
    [
        ("mvmvmvmu", "hinge 1, unassigned, is taken as a valley"),
        ("muvmuuvm", "hinges 2, 5, unassigned, are taken as valleys; hinge 6, unassigned, is taken as a mountain"),
        ("mvmvmvmv", None),
    ],
)
def test_the_faces_that_unassigned_hinges_get_are_told(creases, note, tmp_path, capfd):
    path = written(tmp_path, drawn_circuit(RING_OF_EIGHT, creases))
    facts = json.loads(run_here(["check", path, "--json"], capfd).stdout)
    assert [told for told in facts["reasons"] if "unassigned" in told] == ([] if note is None else [note])
    lines = [line.strip() for line in run_here(["check", path], capfd).stdout.splitlines()]
    assert (note in lines) == (note is not None)
    assert (f"unassigned creases   {note}" in run_here(["show", path], capfd).stdout.splitlines()) == (note is not None)
    proved = run_here(["prove", path, "--output", str(tmp_path / "lock.json")], capfd)
    assert proved.returncode == 0
    assert proved.stderr.splitlines()[1:] == ([] if note is None else [f"{path}: {note}"])


@pytest.mark.parametrize("command", ["check", "show", "motion", "deploy"])
@pytest.mark.parametrize(
    ("creases", "message"),
    [
        ("ffffffff", "all panels of the drawing are one, joined by flat edges (F): assign mountains and valleys"),
        ("mfffffff", "facets 0 and 1 have a hinge between them but belong to one panel: rigid creases lead around it"),
    ],
)
def test_flat_edges_that_leave_no_hinge_free_are_refused_on_a_grid_as_off_it(
    command, creases, message, tmp_path, capfd
):
    path = written(tmp_path, drawn_circuit(RING_OF_EIGHT, creases))
    result = run_here([command, path], capfd)
    assert (result.returncode, result.stdout, len(result.stderr.splitlines())) == (2, "", 1)
    assert f"{path}: {message}" in result.stderr
