"""What the gallery shows: for each picture its command, and a sentence for a reader who has seen none of it before."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hcsearch.basics.vocabulary import plural
from hcsearch.designs.grid import GRIDS
from hcsearch.library.assemblies import ASSEMBLIES


@dataclass(frozen=True)
class ShownPicture:
    """A picture of the gallery.

    file : its name. title : the head of its column. command : what makes it, without the file; of a drawing, what
    prints the same design. sentence : what it shows. option : that of the command to which the file belongs.
    """

    file: str
    title: str
    command: str
    sentence: str = ""
    option: str = "--output"

    @property
    def is_exported(self) -> bool:
        """Whether the command writes the picture."""
        return not self.command.startswith("hcsearch show ")

    @property
    def written(self) -> str:
        """The file that the command writes: a still or a plot is compressed afterwards."""
        return str(Path(self.file).with_suffix(".png")) if self.file.endswith(".webp") else self.file

    @property
    def whole_command(self) -> str:
        """The command as a user types it."""
        return f"{self.command} {self.option} {self.written}" if self.is_exported else self.command


@dataclass(frozen=True)
class Section:
    """Pictures under one heading, with the text that introduces them."""

    heading: str
    text: str
    pictures: tuple[ShownPicture, ...]


_ANIMATION = "--format animation"
_OPENED_BY_SPRINGS = {
    "triangle": "triangle:0123434501:1",
    "square": "square:01222300:1",
    "rectangle": "rectangle:01222300:1",
    "hex": "hex:012223444500:4 --scene hinged",
    "rhombus": "rhombus:231213121210:3",
    "kite": "kite:23203030:3",
    "right45": "right45:12121212:0",
    "right30": "right30:20201210:3",
    "obtuse": "obtuse:121212121212:0",
}
"""The folding of each grid."""
HALF_OPEN_GRIDS = ("rhombus", "kite", "right45", "right30", "obtuse")
"""Grids of which docs/reference/grids.md shows a still, too."""


def _title(grid: str) -> str:
    return plural(GRIDS[grid].exact_noun).capitalize()


GRID_PICTURES = tuple(
    ShownPicture(
        f"moving-{grid}.svg", _title(grid), f"hcsearch export {folding} --motion springs {_ANIMATION}", f"`{grid}`"
    )
    for grid, folding in _OPENED_BY_SPRINGS.items()
)
OTHER_PICTURES = (
    *(
        ShownPicture(
            f"half-open-{grid}.webp",
            _title(grid),
            f"hcsearch export {folding} --motion springs --format png --state 0.5",
        )
        for grid, folding in _OPENED_BY_SPRINGS.items()
        if grid in HALF_OPEN_GRIDS
    ),
    ShownPicture(
        "worked-array.svg",
        "An array of 6 m2",
        f"hcsearch export rectangle:12333011:3 --panel 1000x750x20 --motion springs {_ANIMATION}",
    ),
    *(
        ShownPicture(
            f"half-open-{size}.webp",
            f"Panels of {size} mm",
            f"hcsearch export hex:02234400:1 --panel {size} --motion springs --format png --state 0.5",
        )
        for size in ("50x6", "1000x20")
    ),
    ShownPicture("drive.webp", "A drive", "hcsearch drive hex:0234435011:1", option="--picture"),
    ShownPicture("motion-unit-ii.webp", "A motion", "hcsearch motion unit-ii", option="--picture"),
    ShownPicture(
        "flight-array.svg",
        "An array of twenty squares",
        f"hcsearch export square:01223321123330000121:3 --panel 300x300x12 --motion path {_ANIMATION}",
    ),
)
"""Pictures of other pages than the gallery."""

STATUS_PICTURES = (
    ShownPicture(
        "deploys.svg",
        "deploys",
        f"hcsearch export hex:0234550132:4 --motion springs {_ANIMATION}",
        "Equal springs in all hinges open the folding. The simulated motion is certified for all times: panels that "
        "are shrunk by a stated margin do not overlap.",
    ),
    ShownPicture(
        "movable.svg",
        "movable",
        f"hcsearch export hex:0234435011:1 --motion path {_ANIMATION}",
        "A path from the stacks to the flat array is proved free of collisions, so that motors can open the folding. "
        "None of the springs that were tried does.",
    ),
    ShownPicture(
        "undecided.svg",
        "undecided",
        f"hcsearch export hex:0233535002:0 --motion springs {_ANIMATION}",
        "Neither a path nor a lock is proved. The picture shows how far equal springs get.",
    ),
    ShownPicture(
        "locked.svg",
        "locked",
        f"hcsearch export hex:0234550132:3 --motion springs {_ANIMATION}",
        "It is proved that the folding cannot move, as its flat pairs are rigid: springs press every hinge onto its "
        "stop, and the picture stands still. With hinged flat pairs this folding is not locked.",
    ),
    ShownPicture(
        "twisted.svg",
        "twisted",
        f"hcsearch export hex:02334051:0 --motion springs {_ANIMATION}",
        "The folded band of panels has a full turn of twist, so that no motion leads to the flat array. The picture "
        "stands still, since springs do not open a hinge.",
    ),
    ShownPicture(
        "no-folding.svg",
        "no folding",
        "hcsearch show hex:012345",
        "No two opposite creases of this circuit can stay flat while all others close, so that there is no motion to "
        "show. The circuit is green in the drawing; the command prints the reason.",
    ),
)

_SCENES = {"array-6r": " --scene thesis", "thesis-4x4": " --scene thesis"}
"""Scenes other than `default` in which springs move an assembly further."""


def _assembly_pictures(*chapters: str) -> tuple[ShownPicture, ...]:
    return tuple(
        ShownPicture(
            f"assembly-{name}.svg",
            name,
            f"hcsearch export {name}{_SCENES.get(name, '')} --motion springs {_ANIMATION}",
            f"{assembly.title}; {assembly.source}.",
        )
        for name, assembly in ASSEMBLIES.items()
        if assembly.source.startswith(chapters)
    )


SECTIONS = (
    Section(
        "One design of each grid",
        "A grid is a way to fill the plane with equal panels, each the mirror image of its neighbours. Equal "
        "springs open these designs from two stacks to a flat array. [The eight panels](reference/grids.md) explains "
        "the grids.",
        GRID_PICTURES,
    ),
    Section(
        "What the program says of a folding",
        "Every folding gets one of these words, and a design that of its best folding. "
        "[The glossary](README.md#glossary) defines them.",
        STATUS_PICTURES,
    ),
    Section(
        "Assemblies of triangles",
        "These mechanisms of the thesis consist of isosceles triangles. Most have one degree of freedom: one angle "
        "determines all others. [Assemblies](explanation/assemblies.md) compares each with the thesis.",
        _assembly_pictures("section 5", "not in the thesis"),
    ),
    Section(
        "Assemblies of squares and rectangles",
        "The other mechanisms of the thesis: an array with merged panels, elements of six hinges, and modules.",
        _assembly_pictures("section 4", "section 6"),
    ),
)
"""The page, from top to bottom."""
