"""Any system in Exudyn: a kinematic tree, struts as spring-dampers, welds as generic joints."""

from __future__ import annotations

import time
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.springs.dynamics.body_trees import GROUND
from hcsearch_bench.peers.states import GAPS, Trajectory, installed, lines_of
from hcsearch_bench.run.work_precision import UnableError

if TYPE_CHECKING:
    from hcsearch.springs.dynamics.system import System


SMALL = 60
"""Joints up to which matrices are dense."""
SINGULAR = 1e-9
"""Singular values of constraints below this count as zero when motions are projected onto the closed ones."""
STAGES = {"RK44": 4, "RK67": 9}


def run(
    system: System, q: Reals, v: Reals, times: Reals, *, step: float = 1e-3, integrator: str = "GeneralizedAlpha"
) -> Trajectory:
    """Follow a system in steps of about `step` (s), which must fit into equal spaces between the times.

    integrator : a name of exudyn.DynamicSolverType; explicit ones (RK44, RK67) for systems without welds.
    Where the solver fails, a second one that looks for redundant rows is tried, and its time is the one reported.
    """
    exudyn = installed("exudyn")
    exudyn.config.printToConsole = False
    solvers = ["EXUdense" if system.n_joints <= SMALL else "EigenSparse"] + (["EigenDense"] if system.welds else [])
    for solver in solvers:
        motion = _solved(exudyn, system, q, v, times, step, integrator, solver)
        if motion is not None:
            return motion
    raise UnableError("the solver failed")


def frequencies(system: System, q: Reals) -> Reals:
    """Frequencies of small vibrations about a state, Hz, by its own projection onto the closed motions; rising."""
    exudyn = installed("exudyn")
    exudyn.config.printToConsole = False
    container = exudyn.SystemContainer()
    model = container.AddSystem()
    _build(exudyn, system, q, np.zeros_like(q), model)
    model.Assemble()
    found, _ = model.ComputeODE2Eigenvalues(convert2Frequencies=True, singularValuesTolerance=SINGULAR)
    return np.sort(np.asarray(found, float))


def _solved(
    exudyn: Any, system: System, q: Reals, v: Reals, times: Reals, step: float, integrator: str, solver: str
) -> Trajectory | None:
    container = exudyn.SystemContainer()
    model = container.AddSystem()
    sensors = _build(exudyn, system, q, v, model)
    model.Assemble()
    space = float(times[1] - times[0])
    steps = max(1, round(space / step)) * (len(times) - 1)
    settings = exudyn.SimulationSettings()
    solution = settings.timeIntegration
    solution.numberOfSteps, solution.endTime, solution.adaptiveStep = steps, float(times[-1]), False
    solution.generalizedAlpha.spectralRadius = 0.9
    solution.newton.useModifiedNewton = not system.welds or system.n_joints > SMALL
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = space
    settings.linearSolver.solverType = getattr(exudyn.LinearSolverType, solver)
    settings.linearSolver.ignoreSingularJacobian = solver == "EigenDense"
    begin = time.perf_counter()
    try:
        model.SolveDynamic(
            settings, solverType=getattr(exudyn.DynamicSolverType, integrator), showHints=False, showCausingItems=False
        )
    except (ValueError, RuntimeError):  # its own errors are among these
        return None
    seconds = time.perf_counter() - begin
    qs, vs = (np.array(model.GetSensorStoredData(sensor))[:, 1:] for sensor in sensors)
    if len(qs) != len(times) or not (np.isfinite(qs).all() and np.isfinite(vs).all()):
        return None
    newton = int(model.sys["dynamicSolver"].it.newtonStepsCount)
    return Trajectory(times, qs, vs, seconds, steps * STAGES[integrator] if integrator in STAGES else newton)


def _build(exudyn: Any, system: System, q: Reals, v: Reals, model: Any) -> list[int]:
    """Fill the model; the numbers of the sensors of coordinates and velocities."""
    items: Any = import_module("exudyn.itemInterface")
    constants, stiffnesses, dampings = lines_of(system)
    n = system.n_joints
    frames = [_frame(joint.axis) for joint in system.joints]  # by columns; joints turn about and slide along z
    node = model.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0.0] * n,
            initialCoordinates=list(q),
            initialCoordinates_t=list(v),
            numberOfODE2Coordinates=n,
        )
    )
    transforms = []
    for i, joint in enumerate(system.joints):
        origin, above = np.zeros(3), np.eye(3)
        if joint.parent != GROUND:
            origin, above = system.joints[joint.parent].point, frames[joint.parent]
        transform = np.eye(4)
        transform[:3, :3], transform[:3, 3] = above.T @ frames[i], above.T @ (joint.point - origin)
        transforms.append(transform)
    turns, slides = exudyn.JointType.RevoluteZ, exudyn.JointType.PrismaticZ
    kinds = [slides if joint.slides else turns for joint in system.joints]
    tree = model.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=kinds,
            linkParents=[joint.parent for joint in system.joints],
            jointHTs=transforms,
            linkInertiasCOM=exudyn.Matrix3DList(
                [frame.T @ body.inertia @ frame for frame, body in zip(frames, system.bodies, strict=True)]
            ),
            linkCOMs=exudyn.Vector3DList(
                [
                    frame.T @ (body.centre - joint.point)
                    for frame, body, joint in zip(frames, system.bodies, system.joints, strict=True)
                ]
            ),
            linkMasses=[body.mass for body in system.bodies],
            gravity=list(system.gravity),
            jointForceVector=list(-constants),
            jointPControlVector=list(stiffnesses),
            jointDControlVector=list(dampings),
            jointPositionOffsetVector=[0.0] * n,
            jointVelocityOffsetVector=[0.0] * n,
        )
    )
    ground = model.AddObject(items.ObjectGround())

    def marker(body: int, point: Reals, frame: Reals) -> int:
        """At a point, with the rows of a frame (both in the reference state) as its axes."""
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = frame.T, point
        if body == GROUND:
            number = model.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localHT=place))
        else:
            own = frames[body].T
            place[:3] = own @ place[:3]
            place[:3, 3] -= own @ system.joints[body].point
            number = model.AddMarker(items.MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=body, localHT=place))
        return int(number)

    for strut in system.struts:
        model.AddObject(
            items.ObjectConnectorSpringDamper(
                markerNumbers=[
                    marker(strut.first, strut.first_point, np.eye(3)),
                    marker(strut.second, strut.second_point, np.eye(3)),
                ],
                stiffness=strut.stiffness,
                damping=strut.damping,
                referenceLength=strut.rest,
            )
        )
    for weld in system.welds:
        closed = [0] * 6
        for kind in weld.kinds:
            closed[kind - 3 if kind in GAPS else kind + 3] = 1
        model.AddObject(
            items.ObjectJointGeneric(
                markerNumbers=[marker(body, weld.point, weld.frame) for body in (weld.first, weld.second)],
                constrainedAxes=closed,
            )
        )
    wanted = (exudyn.OutputVariableType.Coordinates, exudyn.OutputVariableType.Coordinates_t)
    return [
        int(model.AddSensor(items.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind)))
        for kind in wanted
    ]


def _frame(axis: Reals) -> Reals:
    """A rotation whose third column is the axis."""
    other = np.eye(3)[int(np.abs(axis).argmin())]
    first = np.cross(other, axis)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])
