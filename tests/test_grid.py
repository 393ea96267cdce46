import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hcsearch.basics.errors import ArrayError, HcsearchError, InputFileError, NotationError, SizeError
from hcsearch.designs.grid import GRIDS, Array, grid_named, parse_array
from hcsearch.designs.grid.arrays import MAX_CELLS, cell_form
from tests.documents import ROOT
from tests.strategies import arrays


@pytest.mark.parametrize("grid", GRIDS.values(), ids=GRIDS)
def test_the_reference_says_of_each_grid_what_its_entry_says(grid):
    page = (ROOT / "docs" / "reference" / "grids.md").read_text(encoding="utf-8")
    row = re.search(rf"^\| `{grid.name}` \| (.*) \|$", page, re.MULTILINE)[1].split(" | ")
    length = grid.given_edge or ("length and width" if grid.stretched else "side")
    assert [row[1], *row[3:]] == [length, str(grid.kinds), str(len(grid.point_group))]


@given(arrays())
def test_corners_are_one_in_whole_numbers_where_they_lie_in_one_place(array):
    grid = array.grid
    keys = [key for cell in array.cells for key in grid.lattice_corners(cell)]
    points = np.array([corner for cell in array.cells for corner in grid.corners(cell)])
    near = np.linalg.norm(points[:, None] - points, axis=2) < 0.1
    assert (near == np.isclose(points[:, None], points, atol=1e-12).all(axis=2)).all()
    assert near.tolist() == [[one == other for other in keys] for one in keys]


@given(arrays())
def test_a_mesh_of_cells_has_the_corners_of_each_and_no_vertex_twice(array):
    vertices, faces = array.grid.mesh(array.cells)
    assert [[vertices[v] for v in face] for face in faces] == [array.grid.corners(cell) for cell in array.cells]
    assert len(set(vertices)) == len(vertices)
    assert list(dict.fromkeys(v for face in faces for v in face)) == list(range(len(vertices)))


@given(arrays())
def test_array_notation_round_trips(array):
    assert Array.from_notation(array.notation) == array
    assert parse_array(array.grid, array.notation) == array


@given(arrays())
def test_canonical_array_is_the_same_for_all_images_and_symmetries_divide_the_group(array):
    images = {
        Array.from_cells(array.grid, [array.grid.cell(isometry(p)) for p in array.points])
        for isometry in array.grid.point_group
    }
    assert {image.canonical() for image in images} == {array.canonical()}
    assert array.symmetry * len(images) == len(array.grid.point_group)
    for isometry, (dx, dy) in array.symmetries():
        assert {(x + dx, y + dy) for x, y in map(isometry, array.points)} == set(array.points)


@given(arrays(max_cells=10))
def test_edges_are_the_neighbouring_pairs(array):
    graph = array.graph()
    assert graph.number_of_nodes() == array.n
    assert graph.number_of_edges() == len(array.edges())
    for i, j, d in array.edges():
        (x, y), (sx, sy) = array.points[i], array.grid.steps[d]
        assert array.points[j] == (x + sx, y + sy)


NEW_SPECS = {
    "hex": {"t2": (3, 6), "h1": (1, 12), "h2": (7, 12), "2-3-2": (7, 12)},
    "triangle": {"t2": (4, 6), "h1": (6, 12), "s1": (12, 12), "s2": (48, 12)},
    "rhombus": {"t2": (9, 6), "h1": (3, 6), "h2": (21, 6), "s1": (6, 12), "p3x2": (18, 1), "2-3-2": (21, 6)},
    "kite": {"t2": (12, 6), "h1": (18, 12), "h2": (72, 12), "s1": (36, 12), "p3x2": (36, 2), "2-3-2": (42, 12)},
    "right45": {"6x4": (48, 4), "4x4": (32, 8), "3x2": (12, 2), "2x2": (8, 8), "p3x2": (24, 4), "p1x1": (4, 8)},
    "right30": {"t2": (24, 6), "h1": (36, 12), "h2": (144, 12), "s1": (72, 12), "p3x2": (72, 2), "2-3-2": (84, 12)},
    "obtuse": {"t2": (12, 6), "h1": (18, 12), "h2": (72, 12), "s1": (36, 12), "p3x2": (36, 2)},
}


@pytest.mark.parametrize(
    ("grid", "spec", "cells", "symmetry"),
    [
        ("square", "6x5", 30, 4),
        ("square", "4x4", 16, 8),
        ("rectangle", "4x4", 16, 4),
        ("square", "p3x2", 6, 4),
        ("hex", "3-4-3", 10, 4),
        ("hex", "4-4-4", 12, 2),
        ("hex", "p5x4", 20, 2),
        ("hex", "t4", 10, 6),
        ("hex", "h3", 19, 12),
        ("triangle", "t5", 25, 6),
        ("triangle", "h2", 24, 12),
        ("triangle", "p3x2", 12, 2),
        ("square", "2x1000", 2000, 4),
        *((grid, spec, *numbers) for grid, specs in NEW_SPECS.items() for spec, numbers in specs.items()),
    ],
)
def test_array_specs(grid, spec, cells, symmetry):
    array = parse_array(grid_named(grid), spec)
    assert (array.n, array.symmetry) == (cells, symmetry)


def test_hexagon_rows_begin_where_the_contract_says():
    def row_starts(spec):
        array = parse_array(GRIDS["hex"], spec)
        top = max(y for _, y in array.cells)
        return [2 * min(x for x, r in array.cells if r == y) + y for y in range(top, -1, -1)]

    def relative(spec):
        first, *rest = row_starts(spec)
        return [start - first for start in rest]

    assert relative("3-4-3") == [-1, 0]
    assert relative("4-4-4-4") == [-1, 0, -1]
    assert relative("3-3-4-4") == [-1, -2, -1]


@pytest.mark.parametrize(
    ("grid", "spec", "error"),
    [
        ("square", "3-4-3", NotationError),
        ("hex", "3-5", NotationError),
        ("hex", "6x5", NotationError),
        ("square", "t4", NotationError),
        ("square", "h2", NotationError),
        ("triangle", "0x3", NotationError),
        ("square", "0x3", NotationError),
        ("square", "six by five", NotationError),
        ("square", "hex:3.1", NotationError),
        ("square", "square:3.g", NotationError),
        ("square", "square:5", ArrayError),
        ("square", "square:0", ArrayError),
        ("square", "3000x3000", SizeError),
        ("square", "@no/such/file", InputFileError),
        *(("right45", spec, NotationError) for spec in ("t2", "h1", "s1", "2-3-2", "0x3", "right30:3")),
        *(("rhombus", spec, NotationError) for spec in ("6x4", "s2", "3-5")),
        *((grid, "6x4", NotationError) for grid in ("kite", "right30", "obtuse")),
        ("obtuse", "2-3-2", NotationError),
        ("right30", "right30:3.0.0.0.0.0.3", ArrayError),
        ("kite", "h200", SizeError),
    ],
)
def test_wrong_specs_are_one_clear_line(grid, spec, error):
    with pytest.raises(error) as caught:
        parse_array(grid_named(grid), spec)
    assert isinstance(caught.value, HcsearchError)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("grid", "spec", "has"),
    [
        ("right45", "t2", "6x5 (columns x rows), p5x4, @file"),
        (
            "rhombus",
            "6x4",
            "3-4-3 (rows of hexagons from the top), t5, h3 (triangle, hexagon by its side), s1 (star), p5x4",
        ),
        (
            "kite",
            "6x4",
            "3-4-3 (rows of hexagons from the top), t5, h3 (triangle, hexagon by its side), s1 (star), p5x4",
        ),
        ("obtuse", "2-3-2", "t5, h3 (triangle, hexagon by its side), s1 (star), p5x4"),
        ("hex", "s1", "3-4-3 (rows of hexagons from the top), t5, h3 (triangle, hexagon by its side), p5x4"),
    ],
)
def test_a_refused_specification_is_answered_with_those_of_the_grid(grid, spec, has):
    with pytest.raises(NotationError) as caught:
        parse_array(grid, spec)
    assert str(caught.value).startswith(f"the {grid} grid has no array '{spec}': use {has}")


@pytest.mark.parametrize(
    ("grid", "cells", "message"),
    [
        (
            "rhombus",
            [(0, 0)],
            r"\(0, 0\) is no cell of the rhombus grid: give \(x, y, k\), k from 0 to 2 in whole numbers",
        ),
        ("right30", [(0, 0, 12)], "k from 0 to 11"),
        ("kite", [(0, 0, -1)], "k from 0 to 5"),
        ("obtuse", [(0, 0, 0.5)], "no cell of the obtuse grid"),
        ("right45", [(0, 0, 0), (0, 0, 0)], "cell 0 0 0 is given twice"),
        ("right45", [(0, 0, 0), (0, 0, 2)], r"not connected \(2 pieces\)"),
    ],
)
def test_cells_that_are_no_array_of_a_grid(grid, cells, message):
    with pytest.raises(ArrayError, match=message):
        Array.from_cells(grid, cells)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 0\n5 5\n", "not connected"),
        ("0 0\n1 0\n0 0\n", "given twice"),
        ("0 0\n1 x\n", "line 2"),
        ("0 0 0\n", "line 1"),
        ("# nothing\n\n", "cells.txt holds no cells: write one a line, as 0,0, or draw rows of X and ."),
        ("", "cells.txt holds no cells"),
        ("0 0\n1 0\n0 0\n", "cells.txt: cell 0 0 is given twice"),
        ("x,y\n0,0\n", "cells.txt: line 1: 'x,y' is no heading of cells: write q,r"),
        ("q,r\n0,0,1\n", "cells.txt: line 2: '0,0,1' is no cell: write q,r"),
        ("r,q\n0,0,1\n", "write r,q"),
    ],
)
def test_wrong_files(tmp_path, text, message):
    file = tmp_path / "cells.txt"
    file.write_text(text)
    with pytest.raises(ArrayError, match=message):
        parse_array(GRIDS["hex"], f"@{file}")


def test_file_of_cells(tmp_path):
    file = tmp_path / "cells.txt"
    file.write_text("# up and down\n0 0 0\n0, 0, 1\n-1 0 1  # left\n")
    assert parse_array(GRIDS["triangle"], f"@{file}").n == 3


@given(arrays())
def test_files_of_cells_give_the_array_of_the_cells(array):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "cells.txt"
        file.write_text("".join(" ".join(map(str, cell)) + "\n" for cell in array.cells))
        assert parse_array(array.grid, f"@{file}") == array


@given(arrays(), st.sampled_from([",", "; ", "\t"]), st.randoms())
def test_files_of_cells_may_have_a_heading_in_any_order(array, comma, random):
    names, _ = cell_form(array.grid)
    order = random.sample(range(len(names)), len(names))
    lines = [comma.join(f'"{names[k].upper()}"' for k in order)]
    lines += [comma.join(str(cell[k]) for k in order) for cell in array.cells]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "cells.csv"
        file.write_text("\r\n".join(lines))
        assert parse_array(array.grid, f"@{file}") == array


@pytest.mark.parametrize(
    ("grid", "drawing", "same"),
    [
        ("square", "XXX / XXX", "3x2"),
        ("square", "X X X/X X X", "3x2"),
        ("rectangle", "..xx/..xx/..xx", "2x3"),
        ("right45", "XX/XX", "p2x2"),
        ("square", "XXX / X.X / XXX", "square:7.5.7"),
        ("square", "XX. / .XX", "square:6.3"),
        ("hex", "X X X / X X X X /  X X X", None),
        ("hex", " X X X /X X X X/ X X X", "3-4-3"),
        ("hex", ".X.X.X./X.X.X.X/.X.X.X.", "3-4-3"),
        ("kite", " X X / X X X /  X X", "2-3-2"),
        ("kite", " X X /X X X/ X X", "2-3-2"),
        ("rhombus", ".X.X/X.X.X", "2-3"),
        ("triangle", ".X./XXX", None),
        ("triangle", "XXX/XXX", "h1"),
        ("obtuse", "XXX/XXX", "h1"),
        ("triangle", ".XXX", "triangle:7"),
        ("square", "XXX / X X / XXX", "square:7.5.7"),
        ("square", "XXX/X X/XXX", "square:7.5.7"),
        ("square", "X X X / X   X / X X X", "square:7.5.7"),
        ("square", "X X X / X . X / X X X", "square:7.5.7"),
        ("square", "X\tX\tX/X\t\tX/X\tX\tX", "square:7.5.7"),
        ("square", "XXX\r\nX X  \nXXX\t\n\n", "square:7.5.7"),
        ("square", "\ufeff\n    XXX\n    X X\n    XXX\n    ", "square:7.5.7"),
        ("square", "XXX /\nX X /\nXXX", "square:7.5.7"),
        ("rectangle", "XX / X / XX", "rectangle:3.1.3"),
        ("square", " XX\nXX", "square:3.6"),
        ("square", "###/#.#/###", "square:7.5.7"),
        ("square", "OOO/o O/ooo", "square:7.5.7"),
        ("square", "111/101/111", "square:7.5.7"),
        ("square", "1 1 1\n1 0 1\n1 1 1", "square:7.5.7"),
        ("hex", " X X X\nX X X X\n X X X", "3-4-3"),
        ("hex", "XXX\n\nXXX", None),
        ("square", "XXX / / XXX", None),
        ("square", "XXX\n\nXXX", None),
        ("square", "X X X / X.X / X X X", None),
    ],
)
def test_drawings(grid, drawing, same):
    if same is None:
        with pytest.raises(HcsearchError):
            parse_array(grid, drawing)
    else:
        assert parse_array(grid, drawing).canonical() == parse_array(grid, same).canonical()


@given(arrays())
def test_drawn_arrays_are_the_arrays(array):
    grid = array.grid
    if grid.name not in ("square", "rectangle", "hex", "triangle"):
        return
    places = {}
    for x, y, *kind in array.cells:
        column = x if grid.name in ("square", "rectangle") else 2 * x + y + sum(kind)
        places[column, -y] = "X"
    top, left = (min(place[axis] for place in places) for axis in (1, 0))
    left -= (left - top) % 2  # upright triangles where column and row are even
    height, width = (max(place[axis] for place in places) for axis in (1, 0))
    rows = [
        "".join(places.get((column, row), ".") for column in range(left, width + 1)) for row in range(top, height + 1)
    ]
    assert parse_array(grid, "/".join(rows)) == array
    assert parse_array(grid, " / ".join(rows)) == array
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "drawn.txt"
        file.write_text("# drawn\n" + "\n".join(rows))
        assert parse_array(grid, f"@{file}") == array


@given(
    st.lists(st.text("X ", min_size=1, max_size=5), min_size=1, max_size=5),
    st.sampled_from(["X", "x", "#", "O", "1"]),
    st.sampled_from([("", ""), (" ", ""), ("\t", ""), ("", "  "), ("", "\t \r")]),
)
def test_a_blank_is_an_empty_place_however_a_drawing_is_written(rows, sign, written):
    """Where every second place is blank, blanks part the places, and a drawing of single columns is another one."""
    between, after = written
    assume(any("X" in row for row in rows) and any(row[1::2].strip() for row in rows) and rows[0][0] == "X")
    cells = [(x, -y) for y, row in enumerate(rows) for x, mark in enumerate(row) if mark == "X"]
    lines = [between.join(row.replace("X", sign)) + after for row in rows]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "drawn.txt"
        file.write_text("\n".join(lines), encoding="utf-8-sig")
        # digits that blanks part are cells
        texts = ["\n".join(lines)] * (len(rows) > 1 or sign != "1") + ([f"@{file}"] if sign != "1" else [])
        for text in texts:
            try:
                expected = Array.from_cells("square", cells)
            except ArrayError as error:
                with pytest.raises(ArrayError, match=re.escape(str(error))):
                    parse_array("square", text)
            else:
                assert parse_array("square", text) == expected


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("XXX/ X X/XXX", "row 2 of 'XXX/ X X/XXX' begins with a blank: write ' / ' between all rows, and . for an"),
        ("XXX / X.X/XXX", "row 2 of .* begins with a blank"),
        (" XX / XX", "row 1 of 'XX / XX' begins with a blank"),
        ("XOX/OXO", "the drawing has the signs O and X: draw cells as X and empty places as ."),
        ("XXX/X_X/XXX", "row 2: 'X_X' is no row of a drawing: draw cells as X, or all as O, # or 1, and empty places"),
        ("111 / 1-1 / 111", "row 2: '1-1' is no row of a drawing"),
        ("XX / / XX", "not connected .2 pieces.: join them by shared edges; a blank in a drawing is an empty place"),
    ],
)
def test_ambiguous_drawings_are_refused(spec, message):
    with pytest.raises(HcsearchError, match=message):
        parse_array("square", spec)


RING = "square:7.5.7"


@pytest.mark.parametrize(
    ("grid", "text", "notation"),
    [
        ("square", "0.0,0.0\n1.0,0.0\n1.0,1.0\n0.0,1.0\n", "square:3.3"),
        ("square", "0.000000000000000000e+00 1.0e+00\n1.0e0 +1.\n", "square:3"),
        ("square", "0,0,0\n1,1,0\n2,1,1\n3,0,1\n", "square:3.3"),
        ("square", ",x,y\n0,0,0\n1,1,0\n2,1,1\n", "square:3.2"),
        ("square", "   x  y\n0  0  0\n7  1  0\n4  1  1\n", "square:3.2"),
        ("square", "index;y;x\n5;0;0\n7;1;0\n", "square:1.1"),
        ("square", '"Unnamed: 0","x","y"\n5,0,0\n7,1,0\n', "square:3"),
        ("square", '"x","y"\r\n"0","0"\r\n"1.0","0.0"\r\n', "square:3"),
        ("square", "[[0 0]\n [1 0]\n [1 1]]", "square:3.2"),
        ("square", "1 1\n1 0\n0 1", "square:2.3"),
        ("triangle", ",x,y,u\n0,0,0,0\n1,0,0,1\n", "triangle:3"),
        ("square", "###\n#.#\n###\n", RING),
        ("square", "# a ring\n###\n#.#\n###\n", RING),
        ("square", "# a ring\n  # of eight\nXXX # above\nX X\nXXX\n", RING),
        ("square", "111\n101\n111\n", RING),
        ("square", "OOO\nO.O\nOOO\n", RING),
        ("square", "\n \nXXX\nX X\nXXX\n\n", RING),
        ("hex", "# row\n X X\nX X X\n", "hex:7.3"),
    ],
)
def test_files_as_other_programs_write_them(grid, text, notation, tmp_path):
    (tmp_path / "cells.txt").write_text(text, encoding="utf-8-sig")
    assert parse_array(grid, f"@{tmp_path / 'cells.txt'}").notation == notation


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0.5,1\n1,1", "line 1: '0.5,1' is no cell: write x,y"),
        ("nan,1\n1,1", "line 1"),
        ("0,0,0\n5,1,0\n", "line 1: '0,0,0' is no cell: write x,y"),
        ("k,x,y\n0,0,0\n", "'k,x,y' is no heading of cells: write x,y, or draw rows of X and ."),
        ("1 1 1\n1 0 1\n1 1 1", "is no cell: write x,y, or draw rows of 1 and 0 without blanks"),
        ("1.0e+00 1.0 1.0\n1.0 0.0 1.0", "is no cell: write x,y, or draw rows of 1 and 0 without blanks"),
        ("[[1 1 1]\n [1 0 1]]", "is no cell: write x,y, or draw rows of 1 and 0 without blanks"),
        ("XX#X\nXXXX", "the drawing has the signs # and X"),
        ("***\n*.*", "'[*]{3}' is no heading of cells: write x,y, or draw rows of X and ."),
        ("XXX\n\nX_X\nX_X\n", "cells.txt: line 3: 'X_X' is no row of a drawing: draw cells as X, .* as . or blanks"),
        ("_X_\nXXX\n", "line 1: '_X_' is no row of a drawing"),
        ("111\n1-1\n111\n", "line 2: '1-1' is no row of a drawing"),
        ("XXX\n\nXXX\n", "not connected .2 pieces.: .*; a blank in a drawing is an empty place"),
        ("...\n", "has no cell: draw cells as X"),
        ("# note\n#####\n", "holds no cells: .*# begins a comment"),
    ],
)
def test_files_that_are_no_array_are_refused_with_the_remedy(text, message, tmp_path):
    (tmp_path / "cells.txt").write_text(text)
    with pytest.raises(HcsearchError, match=message):
        parse_array("square", f"@{tmp_path / 'cells.txt'}")


def test_a_drawing_of_hexagons_side_by_side_is_refused_with_the_remedy():
    with pytest.raises(
        NotationError, match=r"row 1 of the drawing .* two places wide.*shifted by one, as in \.X\.X\./X"
    ):
        parse_array("hex", "XXX / X.X")


def test_a_file_with_a_cell_of_a_kind_that_the_grid_has_not(tmp_path):
    file = tmp_path / "cells.txt"
    file.write_text("0 0 0\n0 0 3\n")
    with pytest.raises(ArrayError, match="line 2: '0 0 3' is no cell: write x,y,k with k from 0 to 2"):
        parse_array("rhombus", f"@{file}")


def test_arrays_have_a_largest_size(tmp_path):
    file = tmp_path / "cells.txt"
    file.write_text("".join(f"{x} 0\n" for x in range(MAX_CELLS + 1)))
    for spec in (f"@{file}", "square:" + "f" * (MAX_CELLS // 4 + 1), ".".join(["hex:f", "f" * 50_000])):
        with pytest.raises(SizeError, match="larger than 20000 cells: take a smaller one"):
            parse_array(GRIDS[spec.partition(":")[0] if ":" in spec else "square"], spec)
    file.write_text("".join(f"{x} 0\n" for x in range(MAX_CELLS)))
    assert parse_array(GRIDS["square"], f"@{file}").n == MAX_CELLS


def test_wide_arrays_show_themselves():
    wide = parse_array(GRIDS["square"], "20000x1")
    assert eval(repr(wide)) == wide  # the text of `repr` rebuilds the object
    assert Array.from_notation(wide.notation) == wide


@given(arrays())
def test_repr_rebuilds_the_array(array):
    assert eval(repr(array)) == array


@pytest.mark.parametrize(
    "text", ["\0", "\udcff", "hex\0", "\ud800:f", "@\0", "@\ud800", "@" + "a" * 5000, "@/dev/zero"]
)
def test_strange_texts_are_one_printable_line(text):
    for read in (lambda: parse_array(GRIDS["hex"], text), lambda: Array.from_notation(text), lambda: grid_named(text)):
        with pytest.raises(HcsearchError) as caught:
            read()
        assert str(caught.value).isprintable()
        assert len(str(caught.value)) < 500


def test_unknown_grid():
    with pytest.raises(
        NotationError, match="triangle, square, rectangle, hex, rhombus, kite, right45, right30, obtuse"
    ):
        grid_named("octagon")
