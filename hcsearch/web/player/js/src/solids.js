// Facets as solids: polygons with chamfered edges, hinge leaves, slits and pins, in the flat state, in mm.

export const KINDS = ['top', 'bottom', 'wall', 'cut', 'slit', 'rim', 'mountain', 'valley', 'flat'];
const [TOP, BOTTOM, WALL, CUT, SLIT, RIM, MOUNTAIN, VALLEY, FLAT] = KINDS.keys();

const CHAMFER = 0.012; // of the mean side of a panel
const LEAF = 0.05;
const EDGE = 0.012;
const SLITS = 0.022;
const PIN = 0.018;
const OVERLAP = 0.002;

/**
 * Of each facet its panel, its corners and their middle, how far it reaches around that, and its polygons, each with
 * corners [x, y, z], counterclockwise as seen from outside, and a kind.
 */
export function solidsOf(payload) {
    const { unit, facets, panel, creases, hinges } = payload;
    const thickness = unit * payload.thickness;
    const corner = (k) => [unit * payload.corners[2 * k], unit * payload.corners[2 * k + 1]];
    const joints = new Map(creases.map(([i, j, hinge]) => [`${i} ${j}`, hinge]));
    const sides = new Map();
    facets.forEach((facet, f) => facet.forEach((a, k) => sides.set(`${a} ${facet[(k + 1) % facet.length]}`, f)));
    const size = meanSide(
        facets.map((facet) => facet.map(corner)),
        panel,
    );
    return facets.map((facet, f) => {
        const points = facet.map(corner);
        const edges = facet.map((a, k) => {
            const other = sides.get(`${facet[(k + 1) % facet.length]} ${a}`);
            if (other === undefined) return { kind: 'rim' };
            const hinge = joints.get(`${Math.min(f, other)} ${Math.max(f, other)}`);
            if (hinge === undefined) return { kind: panel[f] === panel[other] ? 'inner' : 'slit' };
            if (hinge < 0) return { kind: 'inner' };
            const [, , , , top, closes, first] = hinges[hinge];
            return {
                kind: 'hinge',
                top: Boolean(top),
                fold: closes ? (top ? VALLEY : MOUNTAIN) : FLAT,
                first: first === panel[f],
            };
        });
        const middle = middleOf(points);
        const polygons = polygonsOf(points, edges, thickness, size);
        return { panel: panel[f], points, middle, reach: reachOf(points, middle), polygons };
    });
}

function polygonsOf(points, edges, thickness, size) {
    const polygons = [];
    const n = points.length;
    const bevel = Math.min(CHAMFER * size, 0.2 * thickness);
    const depth = (edge, top) => {
        // facets of one panel overlap a little: corners that only nearly meet would leave pinholes
        if (edge.kind === 'inner') return -OVERLAP * size;
        return edge.kind === 'hinge' && edge.top === top ? 0 : bevel;
    };
    for (const top of [true, false]) {
        const z = top ? thickness : 0;
        const low = top ? thickness - bevel : bevel;
        const rim = inset(
            points,
            edges.map((edge) => depth(edge, top)),
        );
        const widths = edges.map((edge) => {
            if (edge.kind === 'inner') return 0;
            if (edge.kind === 'hinge' && edge.top === top) return LEAF * size;
            return edge.kind === 'slit' ? SLITS * size : EDGE * size;
        });
        const face = inset(rim, widths);
        const add = (corners, kind) => polygons.push({ corners: top ? corners : corners.reverse(), kind });
        add(
            face.map(([x, y]) => [x, y, z]),
            top ? TOP : BOTTOM,
        );
        for (let k = 0; k < n; k++) {
            const m = (k + 1) % n;
            const edge = edges[k];
            if (edge.kind === 'inner') continue;
            const strip = edge.kind === 'slit' ? SLIT : edge.kind === 'hinge' && edge.top === top ? edge.fold : RIM;
            add(
                [
                    [...rim[k], z],
                    [...rim[m], z],
                    [...face[m], z],
                    [...face[k], z],
                ],
                strip,
            );
            add(
                [
                    [...points[k], low],
                    [...points[m], low],
                    [...rim[m], z],
                    [...rim[k], z],
                ],
                edge.kind === 'slit' ? CUT : WALL,
            );
        }
    }
    for (let k = 0; k < n; k++) {
        const m = (k + 1) % n;
        const edge = edges[k];
        if (edge.kind === 'inner') continue;
        const [a, b] = [points[k], points[m]];
        const wall = [
            [...a, bevel],
            [...b, bevel],
            [...b, thickness - bevel],
            [...a, thickness - bevel],
        ];
        polygons.push({ corners: wall, kind: edge.kind === 'slit' ? CUT : WALL });
        if (edge.kind === 'hinge' && edge.first)
            pin(polygons, a, b, edge.top ? thickness : 0, Math.min(PIN * size, 0.25 * thickness), edge.fold);
    }
    return polygons;
}

/** A pin along a hinge line, as six sides and two ends. */
function pin(polygons, [ax, ay], [bx, by], z, radius, kind) {
    const length = Math.hypot(bx - ax, by - ay);
    const [u, v] = [(bx - ax) / length, (by - ay) / length];
    const spare = 0.04 * length;
    const ring = (x, y) =>
        Array.from({ length: 6 }, (_, k) => {
            const [c, s] = [radius * Math.cos((k * Math.PI) / 3), radius * Math.sin((k * Math.PI) / 3)];
            return [x - v * c, y + u * c, z + s];
        });
    const from = ring(ax + spare * u, ay + spare * v);
    const to = ring(bx - spare * u, by - spare * v);
    for (let k = 0; k < 6; k++) {
        const m = (k + 1) % 6;
        polygons.push({ corners: [from[k], to[k], to[m], from[m]].reverse(), kind });
    }
    polygons.push({ corners: [...from].reverse(), kind }, { corners: to, kind });
}

/** A convex polygon with each side moved inwards by its own distance. */
function inset(points, distances) {
    const n = points.length;
    return points.map(([x, y], k) => {
        const [a, b] = [points[(k + n - 1) % n], points[(k + 1) % n]];
        const [one, two] = [Math.hypot(x - a[0], y - a[1]), Math.hypot(b[0] - x, b[1] - y)];
        const [p, q] = [(a[1] - y) / one, (x - a[0]) / one];
        const [r, s] = [(y - b[1]) / two, (b[0] - x) / two];
        const [d, e] = [distances[(k + n - 1) % n], distances[k]];
        const det = p * s - q * r;
        if (Math.abs(det) < 1e-6) return [x + p * Math.max(d, e), y + q * Math.max(d, e)];
        return [x + (d * s - e * q) / det, y + (e * p - d * r) / det];
    });
}

function middleOf(points) {
    const n = points.length;
    return points.reduce(([x, y], point) => [x + point[0] / n, y + point[1] / n], [0, 0]);
}

function reachOf(points, [mx, my]) {
    const distances = points.map(([x, y], k) => {
        const [toX, toY] = points[(k + 1) % points.length];
        return Math.abs((toX - x) * (my - y) - (toY - y) * (mx - x)) / Math.hypot(toX - x, toY - y);
    });
    return Math.min(...distances);
}

function meanSide(facets, panel) {
    let area = 0;
    for (const points of facets) {
        points.forEach(([x, y], k) => {
            const [toX, toY] = points[(k + 1) % points.length];
            area += 0.5 * (x * toY - y * toX);
        });
    }
    return Math.sqrt(area / (1 + Math.max(...panel)));
}
