// Where the picture is taken from: it goes with the middle of the panels, turns about it, and frames all states from
// every side.

import { move } from './motion.js';
import { dot } from './vectors.js';

export const FIELD = (24 * Math.PI) / 180;
const STATES = 40;
const DIRECTIONS = 240;
const SPARE = 1.06;
const ASLANT = 0.42;

export class View {
    constructor(motion, solids) {
        this.motion = motion;
        this.solids = solids;
        this.along = longSide(solids);
        const turn = this.along - Math.PI / 2;
        this.home = { turn: turn - ASLANT, lift: 0.72 };
        this.named = {
            top: { turn, lift: Math.PI / 2 },
            front: { turn, lift: 0 },
            side: { turn: this.along, lift: 0 },
        };
        this.reset();
    }

    /** Frame all states of the motion in these poses. */
    fit(posesAt) {
        this.points = extremes(this.motion, this.solids, posesAt);
    }

    /** Look from above, or along or across the long side of the flat array; the zoom and the shift are reset. */
    look(name) {
        Object.assign(this, this.named[name], { zoom: 1, shift: [0, 0] });
    }

    reset() {
        Object.assign(this, this.home, { zoom: 1, shift: [0, 0] });
    }

    orbit(turn, lift) {
        this.turn += turn;
        this.lift = Math.min(1.55, Math.max(-1.55, this.lift + lift));
    }

    zoomBy(factor) {
        this.zoom = Math.min(8, Math.max(0.4, this.zoom * factor));
    }

    /** Shift the picture by shares of its height. */
    pan(right, up) {
        this.shift = [this.shift[0] + right / this.zoom, this.shift[1] + up / this.zoom];
    }

    /** Axes of the picture, where the camera stands, and what lies between the nearest and the farthest depth. */
    frame(aspect, poses) {
        const [ct, st, cl, sl] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.lift), Math.sin(this.lift)];
        const right = [-st, ct, 0];
        const up = [-ct * sl, -st * sl, cl];
        const back = [ct * cl, st * cl, sl];
        const high = Math.tan(FIELD / 2);
        const wide = high * aspect;
        const local = this.points.map((point) => [dot(point, right), dot(point, up), dot(point, back)]);
        let [x, y] = [middle(local, 0), middle(local, 1)];
        const fitting = () =>
            Math.max(
                ...local.map((p) => p[2] + SPARE * Math.max(Math.abs(p[0] - x) / wide, Math.abs(p[1] - y) / high)),
            );
        let distance = fitting();
        for (let round = 0; round < 4; round++) {
            // what the picture shows is put in its middle, at the depth of the motion's middle
            const depth = distance - middle(local, 2);
            x +=
                depth *
                middle(
                    local.map((p) => [(p[0] - x) / (distance - p[2])]),
                    0,
                );
            y +=
                depth *
                middle(
                    local.map((p) => [(p[1] - y) / (distance - p[2])]),
                    0,
                );
            distance = fitting();
        }
        const farthest = Math.max(...local.map((point) => point[2]));
        const centre = middle(local, 2);
        const eye = centre + (distance - centre) / this.zoom;
        const height = 2 * high * (distance - centre);
        x -= this.shift[0] * height;
        y -= this.shift[1] * height;
        const position = middleOf(poses, this.solids).map((m, i) => m + x * right[i] + y * up[i] + eye * back[i]);
        const deepest = Math.min(...local.map((point) => point[2]));
        const span = farthest - deepest;
        const near = Math.max(eye - farthest - 0.1 * span, 0.01 * span);
        return { right, up, back, position, near, far: eye - deepest + 0.1 * span, high, wide };
    }
}

/** The map from a point in space to a point of the picture, in pixels, and its depth. */
export function projection({ right, up, back, position, high }, width, height) {
    const scale = height / (2 * high);
    return (point) => {
        const d = point.map((x, i) => x - position[i]);
        const deep = -dot(d, back);
        return [width / 2 + (scale * dot(d, right)) / deep, height / 2 - (scale * dot(d, up)) / deep, deep];
    };
}

function middle(points, i) {
    let [low, high] = [Infinity, -Infinity];
    for (const point of points) {
        low = Math.min(low, point[i]);
        high = Math.max(high, point[i]);
    }
    return (low + high) / 2;
}

/** The middle of all facets in a state. */
function middleOf(poses, solids) {
    const sum = [0, 0, 0];
    const at = [0, 0, 0];
    for (const { panel, middle: [x, y] } of solids) {
        move(poses, 12 * panel, x, y, 0, at, 0);
        at.forEach((place, i) => (sum[i] += place / solids.length));
    }
    return sum;
}

/** Points of the motion that lie farthest out in some direction, from the middle of the panels. */
function extremes(motion, solids, posesAt) {
    const thickness = motion.payload.unit * motion.payload.thickness;
    const corners = solids.flatMap(({ panel, points }) =>
        points.flatMap(([x, y]) => [0, thickness].map((z) => [panel, x, y, z])),
    );
    const points = new Float64Array(3 * corners.length * (STATES + 1));
    for (let k = 0, to = 0; k <= STATES; k++) {
        const poses = posesAt(motion.begin + (k / STATES) * (motion.end - motion.begin));
        const centre = middleOf(poses, solids);
        for (const [panel, x, y, z] of corners) {
            move(poses, 12 * panel, x, y, z, points, to);
            for (const place of centre) points[to++] -= place;
        }
    }
    const outer = new Set();
    for (let k = 0; k < DIRECTIONS; k++) outer.add(farthest(points, direction(k)));
    return Array.from(outer, (at) => points.slice(at, at + 3));
}

/** Direction k of those that lie about evenly on a sphere, along a spiral. */
function direction(k) {
    const z = 1 - (2 * k + 1) / DIRECTIONS;
    const angle = k * Math.PI * (3 - Math.sqrt(5));
    const across = Math.sqrt(1 - z * z);
    return [across * Math.cos(angle), across * Math.sin(angle), z];
}

/** Where the point begins, among points one after the other, that lies farthest in a direction. */
function farthest(points, [u, v, w]) {
    let best = 0;
    let most = -Infinity;
    for (let at = 0; at < points.length; at += 3) {
        const far = u * points[at] + v * points[at + 1] + w * points[at + 2];
        if (far > most) {
            best = at;
            most = far;
        }
    }
    return best;
}

/** The direction of the long side of the flat array. */
function longSide(solids) {
    let [xx, xy, yy] = [0, 0, 0];
    const all = solids.flatMap((solid) => solid.points);
    const [mx, my] = [0, 1].map((i) => all.reduce((sum, p) => sum + p[i], 0) / all.length);
    for (const [x, y] of all) {
        xx += (x - mx) ** 2;
        xy += (x - mx) * (y - my);
        yy += (y - my) ** 2;
    }
    return Math.abs(xx - yy) + Math.abs(xy) < 1e-6 * (xx + yy) ? 0 : 0.5 * Math.atan2(2 * xy, xx - yy);
}
