"""The quantities that users can query, by view and in order.

Tables, SQL views, upserts, the check of queries, ranks, reports and the help of commands use these. The imports of this
module are light. SQL is plain, for SQLite and PostgreSQL, with NULL where a stage has not run, and booleans as 0 or 1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hcsearch.basics.vocabulary import (
    DESIGN_STATUSES,
    ENDINGS,
    FOLDING_STATUSES,
    KEEPS,
    MOTION_ENDS,
    STATUS_EVIDENCE,
    UNIT_PATHS,
    VERDICTS,
    WAYS,
)
from hcsearch.designs.grid import GRIDS
from hcsearch.store.quantity import LISTED, Quantity, in_table, not_null

if TYPE_CHECKING:
    from hcsearch.designs.records import FlightNumbers, FlightValue

_GRIDS = tuple(GRIDS)

# `half` is about the value of a 4x4 array, the example of the thesis: 16 panels, 10 degrees of freedom, a mirror, flat
# after half a second, with a clearance of ten times the smallest one (0.1 mm).
_MECHANISM = (
    Quantity("merged_panels", "integer", "", "panel pairs made one on the mirror axis", label="merged pairs"),
    Quantity(
        "kutzbach_merged",
        "integer",
        "",
        "Kutzbach count after the mirror merge, flat pairs rigid",
        label="Kutzbach count, merged",
    ),
    Quantity(
        "dof_merged",
        "integer",
        "",
        "degrees of freedom after the merge, flat pairs rigid",
        better="lower",
        label="freedoms, merged",
    ),
)
# A folding with twist never deploys, nor does a design without an untwisted folding: this is known before later stages.
# A verdict in a scene has precedence over the status from enumeration.
_DESIGN, _FOLDING = "coalesce(o.status, d.status)", "coalesce(v.status, f.status)"
_DESIGN_TWISTED = "d.n_foldings > 0 AND d.n_untwisted = 0"


def _judged(verdict: str, status: str, twist: str, deployable: str) -> tuple[Quantity, ...]:
    """Return the columns of a verdict from SQL for the word of the verdict, the status, the twist, and `deployable`."""
    known = f"""CASE
        WHEN {twist} > 0 THEN 'twist'
        WHEN {verdict} = 'deploys' THEN 'deployment'
        WHEN {verdict} = 'movable' THEN 'path_proved'
        WHEN {status} = 'locked' AND m.lock_pairs IS NOT NULL THEN 'kept_apart'
        WHEN {status} = 'locked' THEN 'locked_at_end'
        WHEN m.states > 0 THEN 'path_met'
        WHEN m.states = 0 THEN 'no_path_met'
    END"""
    return (
        Quantity(
            *("deployable", "boolean", "", "1: deploys or movable; 0: no folding, twisted or locked; null: not known"),
            sql=deployable,
        ),
        Quantity(
            *("flat_pairs", "text", "", "how flat pairs are joined in the proved path: rigid, hinged or merged", WAYS),
            label="flat pairs of the path",
            table="motion",
        ),
        Quantity(
            *("known", "text", "", "evidence for the status: a deployment, a path, a search without one, or a proof"),
            words=STATUS_EVIDENCE,
            label="evidence",
            sql=known,
        ),
        Quantity(
            *("critical_margin", "real", "mm"),
            "least play for each face at which a path is proved, whatever the scene's",
            better="lower",
            label="critical margin",
            table="motion",
        ),
        Quantity(
            *("unmet_margin", "real", "mm"),
            "greatest play below the critical margin at which the search found no path",
            label="margin without a path",
            table="motion",
        ),
        *_OF_VERDICT,
    )


# The motion behind the status is the deployment for `deploys`, the path for `movable`.
_OF_VERDICT = in_table(
    "verdict",
    Quantity(
        *("needed_margin", "real", "mm", "least play for each face at which the deployment, else the path, is clear"),
        better="lower",
        half=0.02,
    ),
    Quantity(
        *("least_gap", "real", "mm", "least gap of the panels as built in that motion; below 0 they overlap"),
        better="higher",
    ),
    Quantity(
        *("min_clearance", "real", "mm", "smallest gap to which panels come back; below 0 where they overlap as built"),
        better="higher",
        half=1.0,
        label="clearance",
    ),
    Quantity(
        *("deploy_time", "real", "s"),
        "time from folded to flat, in the digits on which tolerances agree; null if they differ by over a tenth",
        better="lower",
        half=0.5,
        label="time to flat",
    ),
)

# Errors of a deployment that becomes flat, certified clear. Worth 1/2 are errors that leave three digits of both;
# weights are 0 unless given, since a tighter tolerance changes them, and no design is better for it.
_ERRORS = (
    Quantity(
        *("error_angle", "real", "rad", "estimated greatest error of the fold angles, until tolerances part"),
        better="lower",
        half=1e-3,
        label="error of angles",
        weight=0.0,
    ),
    Quantity(
        *("error_time", "real", "s", "estimated error of the time to flat, rounding included"),
        better="lower",
        half=1e-3,
        label="error of time to flat",
        weight=0.0,
    ),
)


def _errors_of(design: str, crease: str) -> tuple[Quantity, ...]:
    """Return the errors of the one deployment of a folding that has become flat, from SQL for its key."""
    of_folding = f"FROM deployment AS p WHERE p.design_id = {design} AND p.crease = {crease}"
    return tuple(
        one._replace(sql=f"(SELECT p.{one.name} {of_folding} AND p.base = :scene AND p.status = 'deploys')")
        for one in _ERRORS
    )


# Worth 1/2 are demands of ECSS-E-ST-33-01C (7.5 for margins, 3 for clearances), and figures of flown arrays. Weights
# are 0 unless given, since the figures depend on hardware that the scene `default` does not have.
FLIGHT_QUANTITIES = (
    Quantity(
        *(
            "torque_margin",
            "real",
            "",
            "least ratio of the torque of springs to resisting torques over the travel: a lower bound, proved of a "
            "path, but for parts beside singular states, in which states are sampled",
        ),
        better="higher",
        half=7.5,
        weight=0.0,
    ),
    Quantity("torque_margin_hinge", "text", "", "hinge that limits the torque margin, as named in pictures"),
    Quantity("torque_margin_at", "real", "", "share of the travel where the torque margin is least, 0 packed, 1 flat"),
    Quantity(
        *(
            "torque_margin_failed",
            "real",
            "",
            "torque margin with the worst single spring missing, known as that one is",
        ),
        better="higher",
        half=7.5,
        weight=0.0,
    ),
    Quantity(
        *("deployed_hz", "real", "Hz", "first frequency of the flat array on its latches, a lower bound"),
        better="higher",
        half=1.0,
        weight=0.0,
        label="deployed frequency",
    ),
    Quantity("soft_modes", "integer", "", "directions of the flat array in which no latch is stiff", better="lower"),
    Quantity(
        *("latch_torque", "real", "N m", "torque at a latch that takes the energy of all springs, an upper bound"),
        better="lower",
        half=10.0,
        weight=0.0,
    ),
    Quantity(
        *("latch_impulse", "real", "N m s", "impulse that the root takes as hinges arrive flat, an upper bound"),
        better="lower",
    ),
    Quantity(
        *(
            "clearance_ratio",
            "real",
            "",
            "least gap of panels not stacked or joined over tolerances, a lower bound",
        ),
        better="higher",
        half=3.0,
        weight=0.0,
    ),
    Quantity("self_stresses", "integer", "", "states of self-stress of the flat array", better="lower"),
    Quantity(
        *("flatness_mm_per_mrad", "real", "mm/mrad", "greatest distance from the mean plane per error of the stops"),
        better="lower",
        half=1.0,
        weight=0.0,
        label="flatness",
    ),
    Quantity("tilt", "real", "mrad/mrad", "greatest tilt of a panel per error of the stops", better="lower"),
    Quantity("stowed_length", "real", "mm", "longer side of the footprint of the two stacks"),
    Quantity("stowed_width", "real", "mm", "shorter side of the footprint of the two stacks"),
    Quantity("stowed_height", "real", "mm", "height of the two stacks", better="lower"),
    Quantity(
        *("area_per_volume", "real", "1/m", "flat area over the volume of the stowed box"),
        better="higher",
        half=50.0,
        weight=0.0,
    ),
    Quantity("mass", "real", "kg", "mass of the panels with what is mounted on them", better="lower"),
    Quantity(
        *("craft_clearance", "real", "mm", "least gap of panels to the craft over the travel, a lower bound"),
        better="higher",
    ),
)


def flight_value(quantity: Quantity, numbers: FlightNumbers) -> FlightValue:
    """Return a figure in the unit of its column; None where it is not known or not finite."""
    return quantity.stored(numbers.get(quantity.name))


BEST_CREASE = "(SELECT b.best_crease FROM outcome AS b WHERE b.design_id = d.id AND b.scene = :scene)"
"""SQL for the crease of the best folding of a design `d` in a scene."""

DESIGN_QUANTITIES = (
    Quantity("id", "integer", "", "number of the design in this database"),
    *not_null(
        Quantity("grid", "text", "", "tiling: " + ", ".join(_GRIDS), _GRIDS),
        Quantity("n", "integer", "", "number of panels", label="panels"),
        Quantity("array", "text", "", "notation of the array, equal for congruent arrays"),
        Quantity("circuit", "text", "", "notation of the circuit, equal for congruent circuits"),
        Quantity(
            "array_symmetry", "integer", "", "order of the symmetry group of the array", label="symmetry of the array"
        ),
        Quantity(
            *("symmetry", "integer", "", "order of the symmetry group of the circuit"),
            better="higher",
            half=2.0,
            check="> 0 AND array_symmetry >= symmetry",
        ),
    ),
    Quantity(
        *("orbit_size", "integer", "", "circuits on this array congruent to this one, itself included"),
        sql="d.array_symmetry / d.symmetry",
    ),
    Quantity(
        *("n_fixed", "integer", "", "fixed circuits (up to translation) that are congruent to this one"),
        label="fixed copies",
        required=True,
    ),
    Quantity("n_foldings", "integer", "", "two-stack foldings", label="foldings"),
    Quantity(
        *("two_stack", "boolean", "", "1 when there is a two-stack folding"),
        label="two-stack",
        sql="CASE WHEN d.n_foldings > 0 THEN 1 WHEN d.n_foldings = 0 THEN 0 END",
    ),
    Quantity("n_untwisted", "integer", "", "two-stack foldings without twist", label="untwisted foldings"),
    Quantity(
        *("untwisted", "boolean", "", "1 when there is an untwisted folding"),
        sql="CASE WHEN d.n_untwisted > 0 THEN 1 WHEN d.n_untwisted = 0 THEN 0 END",
    ),
    Quantity(
        *("min_twist", "integer", "", "smallest twist of its foldings; null without a folding"),
        label="least twist",
        check=">= 0",
    ),
    *in_table(
        "folding",
        Quantity(
            *("kutzbach", "integer", ""),
            "Kutzbach count 6(n-1)-5j of the best untwisted folding, flat pairs hinged",
            label="Kutzbach count",
        ),
        Quantity(
            *("dof", "integer", "", "degrees of freedom at a generic state, flat pairs hinged (n hinges)"),
            better="lower",
            half=10.0,
            label="degrees of freedom",
        ),
        *_MECHANISM,
    ),
    *_judged(
        *("o.status", _DESIGN, f"CASE WHEN {_DESIGN_TWISTED} THEN 1 END"),
        f"""CASE
        WHEN d.n_foldings = 0 OR ({_DESIGN_TWISTED}) THEN 0
        WHEN {_DESIGN} IN ('no_folding', 'twisted', 'locked') THEN 0
        WHEN o.status IN ('deploys', 'movable') THEN 1
    END""",
    ),
    *_errors_of("d.id", BEST_CREASE),
    Quantity(
        *("status", "text", "", "deploys, movable, undecided, locked, twisted or no_folding"),
        words=DESIGN_STATUSES,
        table="design",
        check=LISTED,
        sql=f"""CASE
        WHEN d.n_foldings = 0 THEN 'no_folding'
        WHEN {_DESIGN_TWISTED} THEN 'twisted'
        ELSE {_DESIGN}
    END""",
    ),
    Quantity(
        *("score", "real", "", "score that `hcsearch rank --save` stored, 0 to 1"),
        better="higher",
        table="score",
        required=True,
    ),
    # Two stacks of n/2 panels cover two cells; every crease but the two flat ones has a hinge in the scene `default`.
    Quantity(
        *("deployment_ratio", "integer", "", "flat area over folded footprint, untwisted"),
        better="higher",
        half=8.0,
        sql="CASE WHEN d.n_untwisted > 0 THEN d.n / 2 END",
    ),
    Quantity(
        *("hinges", "integer", "", "hinges of an untwisted folding, flat pairs rigid (n - 2)"),
        better="lower",
        half=14.0,
        sql="CASE WHEN d.n_untwisted > 0 THEN d.n - 2 END",
    ),
    *in_table("flight", *FLIGHT_QUANTITIES),
)

FOLDING_QUANTITIES = (
    Quantity("design_id", "integer", "", "id of the design"),
    Quantity(
        *("crease", "integer", "", "first flat crease; crease k joins panels k and k+1"),
        check=">= 0 AND opposite > crease",
    ),
    Quantity("opposite", "integer", "", "second flat crease, crease + n/2", required=True),
    Quantity("twist", "integer", "", "|Lk| of the band, in full twists", check=">= 0"),
    Quantity(
        *("untwisted", "boolean", "", "1 when the twist is zero"),
        sql="CASE WHEN f.twist = 0 THEN 1 WHEN f.twist > 0 THEN 0 END",
    ),
    Quantity("kutzbach", "integer", "", "Kutzbach count 6(n-1)-5j, flat pairs hinged", label="Kutzbach count"),
    Quantity(
        *("dof", "integer", "", "degrees of freedom at a generic state of the motion, flat pairs hinged"),
        better="lower",
        label="degrees of freedom",
    ),
    Quantity(
        *("dof_folded", "integer", "", "degrees of freedom at first order, folded, flat pairs hinged"),
        label="freedoms, folded",
    ),
    Quantity(
        "dof_flat", "integer", "", "degrees of freedom at first order, flat, flat pairs hinged", label="freedoms, flat"
    ),
    *_MECHANISM,
    Quantity(
        *("status", "text", "", "deploys, movable, undecided, locked or twisted", FOLDING_STATUSES),
        table="folding",
        check=LISTED,
        sql=f"CASE WHEN f.twist > 0 THEN 'twisted' ELSE {_FOLDING} END",
    ),
    *_judged(
        *("v.status", _FOLDING, "f.twist"),
        f"""CASE
        WHEN f.twist > 0 OR {_FOLDING} IN ('twisted', 'locked') THEN 0
        WHEN v.status IN ('deploys', 'movable') THEN 1
    END""",
    ),
    *_errors_of("f.design_id", "f.crease"),
    *in_table("flight", *FLIGHT_QUANTITIES),
)

_OF_FOLDING = (
    Quantity("design_id", "integer", "", "id of the design"),
    Quantity("crease", "integer", "", "first flat crease of the folding"),
)

MOTION_QUANTITIES = (
    *_OF_FOLDING,
    Quantity("scene", "text", "", "name of the scene"),
    Quantity(
        *("flat_pairs", "text", "", "how flat pairs are joined in the proved path; null without one", WAYS),
        check=LISTED,
    ),
    Quantity("needed_margin", "real", "mm", "least play for each face at which the path is proved", better="lower"),
    Quantity("least_gap", "real", "mm", "least gap of the panels as they are; below 0 they overlap", better="higher"),
    Quantity("slack", "real", "mm", "greatest deviation of panels from their places on the path"),
    Quantity("states", "integer", "", "states of a path, proved or not; 0 without one", required=True),
    Quantity("reason", "text", "", "result of the search, as a sentence", required=True),
    Quantity("as_crease", "integer", "", "crease of the congruent folding that was searched; null for this one"),
    Quantity("efforts", "integer", "", "efforts of the search that were made; `enumerate --budget` allows more"),
    Quantity("lock_pairs", "text", "", "how flat pairs are joined where it is proved locked between its ends", WAYS),
    Quantity("lock_end", "text", "", "end that no motion leaves in that proof: packed or flat", MOTION_ENDS),
    Quantity("lock_cubes", "integer", "", "cubes of fold angles in that proof"),
    Quantity("lock_faces", "integer", "", "faces of cubes that the proof tested"),
    Quantity("critical_margin", "real", "mm", "least play for each face at which a path is proved", better="lower"),
    Quantity("unmet_margin", "real", "mm", "greatest play below it at which the search found no path"),
    Quantity("lock_margin", "real", "mm", "greatest play at which collisions lock it; null for a lock by closure"),
)

DEPLOYMENT_QUANTITIES = (
    *_OF_FOLDING,
    Quantity("scene", "text", "", "name of the scene that was simulated; `hcsearch deploy --scene` takes it"),
    Quantity("base", "text", "", "scene of the verdict: the simulated one, or the one of which it is a variant"),
    *not_null(
        Quantity("pairs", "text", "", "how flat pairs were joined: rigid, hinged or merged", WAYS, check=LISTED),
        Quantity("springs", "text", "", "set of springs that was tried; empty for those of the scene"),
        Quantity("scene_values", "text", "", "the folding and its scene as a TOML file; `hcsearch deploy` takes it"),
        Quantity("formulation", "text", "", "equations of motion that were integrated"),
        Quantity("status", "text", "", "of this deployment: deploys, undecided or collides", VERDICTS, check=LISTED),
        Quantity("reason", "text", "", "reason for the status, as a sentence"),
    ),
    Quantity(
        *("clearance", "real", "mm", "smallest gap to which panels come back, below 0 where they overlap as built"),
        better="higher",
    ),
    Quantity("first_contact", "real", "s", "time of the first collision"),
    Quantity(
        *("deploy_time", "real", "s", "time from folded to flat, if it deploys and tolerances agree on it to a tenth"),
        better="lower",
    ),
    Quantity("energy_error", "real", "", "largest relative error of the energy balance"),
    Quantity("closure_error", "real", "mm", "largest gap of the closed loop"),
    Quantity("method", "text", "", "integrator, or both with the time at which the second takes over"),
    *_ERRORS,
    Quantity("omitted", "text", "", "terms that the scene does not need and the simulation left out, by name"),
    Quantity(
        *("time_saved", "real", "", "share of the work that these save, from counts of joints, equations and pairs"),
        better="higher",
    ),
    Quantity("needed_margin", "real", "mm", "least play for each face at which it is certified clear", better="lower"),
    Quantity("least_gap", "real", "mm", "least gap of the panels as built; below 0 they overlap", better="higher"),
    Quantity("as_crease", "integer", "", "crease of the congruent folding that was simulated; null for this one"),
)

_FUNNEL = (
    Quantity("fixed_circuits", "integer", "", "circuits up to translation; of one array, all its circuits"),
    Quantity("circuits", "integer", "", "non-isomorphic circuits"),
    Quantity("arrays", "integer", "", "arrays of these circuits"),
    Quantity("two_stack", "integer", "", "designs with a two-stack folding"),
    Quantity("untwisted", "integer", "", "designs with an untwisted folding"),
    Quantity("movable", "integer", "", "designs with a proved path from folded to flat, or that deploy"),
    Quantity("deploys", "integer", "", "designs that springs alone open, certified clear"),
)
FUNNEL_COLUMNS = tuple(quantity.name for quantity in _FUNNEL)

RUN_QUANTITIES = (
    Quantity("id", "integer", "", "number of the run"),
    Quantity("started", "text", "", "start, ISO 8601, UTC", required=True),
    Quantity("finished", "text", "", "end; null when it was interrupted"),
    *not_null(
        Quantity("grid", "text", "", "tiling", _GRIDS),
        Quantity("n", "integer", "", "number of panels"),
        Quantity("target", "text", "", "notation of the array; empty for all arrays of n cells"),
        Quantity("keep", "text", "", "what was stored: all, two-stack or untwisted", KEEPS),
        Quantity("until", "text", "", "last requested stage"),
    ),
    Quantity("panel", "text", "mm", "size of the panels, length x width x thickness"),
    Quantity("arguments", "text", "", "arguments of the call, as JSON", required=True),
    Quantity("versions", "text", "", "versions of the program, its packages and its stages, as JSON", required=True),
    *_FUNNEL,
    Quantity("stage_times", "text", "s", "time of each stage, as JSON"),
    Quantity("batches_done", "integer", "", "batches computed by this run"),
    Quantity("batches_reused", "integer", "", "batches taken from earlier runs"),
)

UNIT_QUANTITIES = (
    Quantity("id", "integer", "", "number of the unit in this database"),
    *not_null(
        Quantity("grid", "text", "", "tiling of the element", _GRIDS),
        Quantity("n", "integer", "", "number of panels of the element's circuit"),
        Quantity("circuit", "text", "", "notation of the element's circuit"),
        Quantity("crease", "integer", "", "first flat crease of its folding, rigid as its opposite is"),
    ),
    Quantity(
        *("alpha", "real", "deg", "base angle of isosceles triangles; null on regular grids"),
        check="> 0 AND alpha < 90",
    ),
    Quantity(
        "shape", "text", "", "apex and outer panels of isosceles triangles; empty on regular grids", required=True
    ),
    Quantity("merged", "boolean", "", "1 when panels that meet on the mirror axis are one", required=True),
    Quantity("element_dof", "integer", "", "degrees of freedom of the element alone"),
    *not_null(
        Quantity(
            *("copies", "integer", "", "copies of the element that are laid together"),
            check="> 1 AND panels > 0 AND hinges > 0",
        ),
        Quantity(
            "placements", "text", "", "positions of the copies, as JSON: over, inverted, turn (degrees), shift (mm)"
        ),
        Quantity("panels", "integer", "", "panels of the unit"),
        Quantity("hinges", "integer", "", "hinges of the unit", better="lower"),
        Quantity("directions", "integer", "", "directions of hinges; 1 when all are parallel, a planar linkage"),
        Quantity("loops", "integer", "", "independent loops"),
        Quantity("kutzbach", "integer", "", "Kutzbach count 6(n-1)-5j"),
        Quantity("dof", "integer", "", "degrees of freedom at a generic state of the motion", better="lower"),
    ),
    Quantity("dof_folded", "integer", "", "degrees of freedom at first order, folded"),
    Quantity("dof_flat", "integer", "", "degrees of freedom at first order, flat"),
    *not_null(
        Quantity("rank_gap", "real", "", "least singular value that counts, over the noise"),
        Quantity("deployment_ratio", "real", "", "flat area over footprint of the folded package", better="higher"),
        Quantity("ways", "integer", "", "finite motions out of the folded state, within the stops"),
        Quantity(
            *("path", "text", "", "how the motion from folded ends: flat, stopped, stepwise, none or locked"),
            words=UNIT_PATHS,
            check=LISTED,
        ),
    ),
    Quantity("closure_error", "real", "", "greatest closure residual on that motion, rad or gap over panel size"),
    Quantity("contact", "boolean", "", "1: panels cut through each other on the way; 0: they do not; null: not tested"),
    Quantity(
        *("known", "text", "", "name for `hcsearch assembly`: unit-i, unit-ii (thesis), unit-iii; else empty"),
        required=True,
    ),
)

EVALUATION_QUANTITIES = (
    Quantity("subject", "text", "", "design or assembly, with its sizes"),
    Quantity("setting", "text", "", "values of the scene, and how it was simulated, as JSON"),
    Quantity("springs", "text", "N m/rad", "stiffness of the spring at each hinge, in the order of hinges"),
    Quantity(
        *("outcome", "text", "", "flat, moving, at rest, stuck, jammed, diverged, out of steps or branch-singular"),
        words=ENDINGS,
        required=True,
        check=LISTED,
    ),
    Quantity(
        *("clear", "boolean", "", "1: certified clear until its end; 0: panels collide; null: undecided"),
        check="IN (0, 1)",
    ),
    Quantity("end_time", "real", "s", "end of the simulation", required=True),
    Quantity("collision_time", "real", "s", "time of the first collision"),
    Quantity("first_panel", "integer", "", "panel that collides, by its number in the linkage"),
    Quantity("second_panel", "integer", "", "panel with which it collides, likewise"),
    Quantity(
        *("clearance", "real", "mm", "smallest gap of a motion that becomes flat and clear"),
        better="higher",
        sql='e."gap" * 1000.0',
    ),
    Quantity("speed", "real", "m/s", "approach speed of the panels that collide", better="lower"),
    Quantity("remaining", "real", "", "mean fold angle over pi at the collision, or at the end", better="lower"),
    Quantity("end_remaining", "real", "", "mean fold angle over pi at the end", better="lower"),
    Quantity("widest", "real", "rad", "greatest fold angle at the end", better="lower"),
    Quantity("drift", "real", "", "greatest error of the energy balance, over the largest energy"),
    Quantity("opening", "real", "", "greatest closure residual, rad or gap over panel size"),
    Quantity("steps", "integer", "", "steps of the simulation", required=True),
    Quantity("evaluations", "integer", "", "evaluations of the equations of motion", required=True),
    Quantity("looks", "integer", "", "pairs of panels that were compared", required=True),
)

RANKING_CRITERIA = tuple(quantity for quantity in DESIGN_QUANTITIES if quantity.half is not None)
"""Criteria of `hcsearch rank`."""

VIEWS = {
    "designs": DESIGN_QUANTITIES,
    "foldings": FOLDING_QUANTITIES,
    "motions": MOTION_QUANTITIES,
    "deployments": DEPLOYMENT_QUANTITIES,
    "runs": RUN_QUANTITIES,
    "units": UNIT_QUANTITIES,
    "evaluations": EVALUATION_QUANTITIES,
}


def view_names() -> tuple[str, ...]:
    """Return the names of the SQL views."""
    return tuple(VIEWS)


def column_names(view: str = "designs") -> tuple[str, ...]:
    """Return the column names of a view in printing order."""
    return tuple(quantity.name for quantity in VIEWS[view])


def table_of(view: str, quantity: Quantity) -> str:
    """Return the table that stores a column of a view; empty where the view computes it."""
    return quantity.table or ("" if quantity.sql else view.removesuffix("s"))  # a view has the name of its table


def stored_quantities(table: str) -> dict[str, Quantity]:
    """Return the quantities that a table stores, by name, as its own view has them."""
    return {
        quantity.name: quantity
        for view, quantities in VIEWS.items()
        for quantity in quantities
        if table_of(view, quantity) == table
    }
