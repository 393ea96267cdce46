"""Obvious twins of the multibody kernels: 4 x 4 matrices, dense Jacobians and pseudo-inverses; and random systems."""

import itertools
import math
from dataclasses import dataclass, field

import numpy as np

from hcsearch.scenes.laws import linear_law, quadratic_law
from hcsearch.springs.dynamics.body_trees import Body, TreeJoint, Weld
from hcsearch.springs.dynamics.system import JointDrive, Strut, System
from tests.naive import rotation

ALL = (0, 1, 2, 3, 4, 5)
KINDS = (ALL, (3, 4, 5), (0, 1, 2), (3,), (3, 5), (0, 1, 3, 4, 5), (1, 2, 3))


@dataclass(frozen=True)
class Twin:
    """A system by plain matrices. Poses take points of the reference state to where they are."""

    system: System
    known: dict = field(default_factory=dict)

    @property
    def n(self):
        return self.system.n_joints

    def poses(self, q):
        if q.tobytes() in self.known:
            return self.known[q.tobytes()]
        placed = []
        for joint, x in zip(self.system.joints, q, strict=True):
            own = np.eye(4)
            if joint.slides:
                own[:3, 3] = x * joint.axis
            else:
                own[:3, :3] = rotation(x * joint.axis)
                own[:3, 3] = joint.point - own[:3, :3] @ joint.point
            placed.append((placed[joint.parent] if joint.parent >= 0 else np.eye(4)) @ own)
        self.known[q.tobytes()] = placed
        return placed

    def point(self, q, body, point):
        pose = self.poses(q)[body] if body >= 0 else np.eye(4)
        return pose[:3, :3] @ point + pose[:3, 3]

    def jacobian(self, q, body, point):
        """Angular velocity of a body and velocity of its point, (6, n)."""
        poses, place, columns = self.poses(q), self.point(q, body, point), np.zeros((6, self.n))
        while body >= 0:
            joint, pose = self.system.joints[body], poses[body]
            axis = pose[:3, :3] @ joint.axis
            if joint.slides:
                columns[3:, body] = axis
            else:
                columns[:3, body] = axis
                columns[3:, body] = np.cross(axis, place - (pose[:3, :3] @ joint.point + pose[:3, 3]))
            body = joint.parent
        return columns

    def masses(self, q):
        """Mass matrix, (n, n)."""
        masses = np.zeros((self.n, self.n))
        for i, body in enumerate(self.system.bodies):
            jacobian, turn = self.jacobian(q, i, body.centre), self.poses(q)[i][:3, :3]
            masses += jacobian[:3].T @ turn @ body.inertia @ turn.T @ jacobian[:3]
            masses += body.mass * jacobian[3:].T @ jacobian[3:]
        return masses

    def drift(self, q, v, body, point):
        """Accelerations of a body that velocities alone cause, (6,)."""
        return along(lambda x: self.jacobian(x, body, point) @ v, q, v)

    def forces(self, q, v):
        """Joint forces less what velocities ask for, (n,)."""
        forces = np.zeros(self.n)
        for i, (body, drive) in enumerate(zip(self.system.bodies, self.system.drives, strict=True)):
            jacobian, turn = self.jacobian(q, i, body.centre), self.poses(q)[i][:3, :3]
            inertia, drift = turn @ body.inertia @ turn.T, self.drift(q, v, i, body.centre)
            spin = jacobian[:3] @ v
            forces -= jacobian[:3].T @ (inertia @ drift[:3] + np.cross(spin, inertia @ spin))
            forces += body.mass * jacobian[3:].T @ (self.system.gravity - drift[3:])
            forces[i] -= drive.damping * v[i] + self.system.stop_stiffness * beyond(drive, q[i])
            forces[i] -= self.system.stop_damping * v[i] if beyond(drive, q[i]) else 0.0
        slope = gradient(self.stored, q)
        for strut in self.system.struts:
            growth = gradient(lambda x, s=strut: self.length(x, s), q)
            forces -= strut.damping * growth * (growth @ v)
        for jacobian, normal, weight in self.pushed(q):
            speed = normal @ jacobian @ v
            forces -= weight * abs(speed) * speed * (jacobian.T @ normal)
        return forces - slope

    def pushed(self, q):
        """Of each point on which air acts: the Jacobian of its velocity, (3, n), its normal, and its weight."""
        for facet in self.system.drags:
            normal = self.poses(q)[facet.body][:3, :3] @ facet.normal
            for point, weight in zip(facet.points, facet.weights, strict=True):
                yield self.jacobian(q, facet.body, point)[3:], normal, weight

    def length(self, q, strut):
        ends = (strut.first, strut.first_point), (strut.second, strut.second_point)
        return np.linalg.norm(np.subtract(*(self.point(q, *end) for end in ends)))

    def stored(self, q):
        """Energy of laws and struts; the laws are of one cubic from angle 0."""
        energy = 0.0
        for x, drive in zip(q, self.system.drives, strict=True):
            energy += sum(c * x ** (k + 1) / (k + 1) for k, c in enumerate(drive.law.straight.cubics[0]))
        return energy + sum(0.5 * s.stiffness * (self.length(q, s) - s.rest) ** 2 for s in self.system.struts)

    def height(self, q):
        bodies = enumerate(self.system.bodies)
        return -sum(body.mass * np.dot(self.system.gravity, self.point(q, i, body.centre)) for i, body in bodies)

    def in_stops(self, q):
        """Energy of compliant stops."""
        ways = (beyond(drive, x) for drive, x in zip(self.system.drives, q, strict=True))
        return sum(0.5 * self.system.stop_stiffness * way**2 for way in ways)

    def lost_power(self, q, v):
        power = 0.0
        for drive, x, speed in zip(self.system.drives, q, v, strict=True):
            power += (drive.damping + (self.system.stop_damping if beyond(drive, x) else 0.0)) * speed**2
        growths = [(s, gradient(lambda x, s=s: self.length(x, s), q) @ v) for s in self.system.struts]
        power += sum(weight * abs(normal @ jacobian @ v) ** 3 for jacobian, normal, weight in self.pushed(q))
        return power + sum(s.damping * growth**2 for s, growth in growths)

    def errors(self, q):
        """Closure residuals of all rows."""
        errors, poses = [], [pose[:3, :3] for pose in self.poses(q)]
        for weld in self.system.welds:
            one, two = (poses[body] if body >= 0 else np.eye(3) for body in (weld.first, weld.second))
            free = [axis for kind, axis in enumerate(weld.frame) if kind not in weld.kinds]
            if sum(kind < 3 for kind in weld.kinds) == 2:
                turn = np.cross(one @ free[0], two @ free[0])
            else:
                turn = 0.5 * np.cross(one, two, axis=0).sum(axis=1)
            gap = self.point(q, weld.second, weld.point) - self.point(q, weld.first, weld.point)
            for kind in weld.kinds:
                way = one @ weld.frame[kind % 3]
                errors.append(way @ turn if kind < 3 else way @ gap / self.system.size)
        return np.array(errors)

    def rows(self, q):
        """Relative velocities along the rows by joint velocities, (m, n)."""
        rows = []
        for weld in self.system.welds:
            one = self.poses(q)[weld.first][:3, :3] if weld.first >= 0 else np.eye(3)
            second = self.jacobian(q, weld.second, weld.point)
            relative = second
            if weld.first >= 0:  # the first body carries the row where the second is
                at, pose = self.point(q, weld.second, weld.point), self.poses(q)[weld.first]
                relative = second - self.jacobian(q, weld.first, pose[:3, :3].T @ (at - pose[:3, 3]))
            for kind in weld.kinds:
                way = one @ weld.frame[kind % 3]
                rows.append(way @ (relative[:3] if kind < 3 else relative[3:] / self.system.size))
        return np.array(rows).reshape(-1, self.n)

    def accelerations(self, q, v, held):
        """Accelerations, and what holds held joints, from the dense equations with multipliers; the state is closed."""
        free = ~held
        masses, forces, rows = self.masses(q), self.forces(q, v), self.rows(q)
        wanted = -along(lambda x: self.rows(x) @ v, q, v)
        m, k = len(rows), free.sum()
        matrix = np.block([[masses[np.ix_(free, free)], rows[:, free].T], [rows[:, free], np.zeros((m, m))]])
        solution = np.linalg.pinv(matrix, rcond=1e-10) @ np.concatenate([forces[free], wanted])
        accelerations = np.zeros(self.n)
        accelerations[free] = solution[:k]
        # the multipliers may not be the kernel's, but what they do in joints is, unless the held joints alone close
        holding = masses @ accelerations + rows.T @ solution[k:] - forces
        return accelerations, holding[held]

    def closing_step(self, q, held, unwanted):
        """The change, smallest by the masses, that takes away what is unwanted of each row."""
        free = ~held
        inverse = np.linalg.inv(self.masses(q)[np.ix_(free, free)])
        rows = self.rows(q)[:, free]
        change = np.zeros(self.n)
        change[free] = -inverse @ rows.T @ np.linalg.pinv(rows @ inverse @ rows.T, rcond=1e-9) @ unwanted
        return change

    def closed(self, q, v, held=None):
        """A closed state near another, and the nearest velocities that keep it closed."""
        free = np.zeros(self.n, bool)
        held = free if held is None else held
        for _ in range(30):
            errors = self.errors(q)
            if np.abs(errors).max(initial=0.0) > 100.0:  # it goes astray
                break
            q = q + self.closing_step(q, free, errors)
        v = np.where(held, 0.0, v)
        return q, v + self.closing_step(q, held, self.rows(q) @ v)

    def pushed_apart(self, q, touching, wanted):
        """The least change of velocities, by the masses, with closed loops and -touching * change >= wanted.

        By trying all sets of active stops; None where none will do.
        """
        masses, rows = self.masses(q), self.rows(q)
        _, sizes, vt = np.linalg.svd(rows) if len(rows) else (None, np.zeros(0), np.eye(self.n))
        basis = vt[np.count_nonzero(sizes > 1e-9 * max([1.0, *sizes])) :].T
        inverse = np.linalg.inv(basis.T @ masses @ basis)
        at = np.flatnonzero(touching)
        stops = -touching[at, None] * basis[at]
        stops[np.linalg.norm(stops, axis=1) < 1e-9] = 0.0  # held by the loops
        for size in range(len(at) + 1):
            for chosen in itertools.combinations(range(len(at)), size):
                mine = stops[list(chosen)]
                forces = np.linalg.pinv(mine @ inverse @ mine.T, rcond=1e-9) @ wanted[at[list(chosen)]]
                change = inverse @ mine.T @ forces
                scale = 1e-9 * np.abs(wanted).max()
                if forces.min(initial=0.0) >= -scale and (stops @ change - wanted[at]).min(initial=0.0) >= -scale:
                    return basis @ change
        return None


def beyond(drive, x):
    """How far a joint is beyond its stops."""
    return min(x - drive.lower, 0.0) + max(x - drive.upper, 0.0)


def along(function, q, v):
    """Derivative of a function of the coordinates along velocities; an error of order h^4."""
    h = 1e-3
    one, two = (function(q + k * h * v) - function(q - k * h * v) for k in (1, 2))
    return (8.0 * one - two) / (12.0 * h)


def gradient(function, q):
    """Derivatives of a function by each coordinate, the last axis."""
    return np.stack([along(function, q, own) for own in np.eye(len(q))], axis=-1)


def random_body(rng):
    """A few point masses, which make the inertia one that bodies have."""
    points, masses = rng.normal(size=(5, 3)), rng.uniform(0.1, 1.0, 5)
    centre = masses @ points / masses.sum()
    ways = points - centre
    inertia = sum(m * (w @ w * np.eye(3) - np.outer(w, w)) for m, w in zip(masses, ways, strict=True))
    return Body(masses.sum(), centre + rng.normal(size=3), inertia)


def random_system(seed, *, welds=2, struts=2, bodies=(2, 9), slides=0.3):
    """A random tree, closed in its reference state, with springs, dampers, compliant stops, struts and gravity."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(*bodies))
    joints, laws = [], []
    for i in range(n):
        axis = rng.normal(size=3)
        # long chains, so that loops leave freedom
        parent = i - 1 if rng.random() < 0.7 else int(rng.integers(-1, i))
        joints.append(TreeJoint(parent, axis / np.linalg.norm(axis), rng.normal(size=3), bool(rng.random() < slides)))
        law = [linear_law, quadratic_law][int(rng.integers(2))]
        laws.append(law(*rng.normal(size=3 if law is quadratic_law else 2)))
    bonds = []
    for _ in range(int(rng.integers(0, welds + 1))):
        first, second = sorted(rng.choice(np.arange(-1, n), 2, replace=False).tolist())
        kinds = KINDS[int(rng.integers(len(KINDS)))]
        bonds.append(Weld(first, second, rng.normal(size=3), kinds, rotation(rng.normal(size=3))))
    if bonds and rng.random() < 0.3:
        bonds.append(bonds[0])  # rows that say nothing new
    springs = []
    for _ in range(int(rng.integers(0, struts + 1))):
        first, second = sorted(rng.choice(np.arange(-1, n), 2, replace=False).tolist())
        springs.append(Strut(first, second, *rng.normal(size=(2, 3)), *rng.uniform(0.1, 2.0, 3)))
    stops = [(-math.inf, math.inf), (-0.1, 0.1), (0.1, 0.5)]
    system = System(
        tuple(joints),
        tuple(random_body(rng) for _ in range(n)),
        tuple(JointDrive(law, float(rng.uniform(0.0, 1.0)), *stops[int(rng.integers(3))]) for law in laws),
        tuple(bonds),
        tuple(springs),
        gravity=tuple(rng.normal(size=3)),
        size=float(rng.uniform(0.5, 2.0)),
        stop_stiffness=2.0,
        stop_damping=0.3,
    )
    return system, rng
