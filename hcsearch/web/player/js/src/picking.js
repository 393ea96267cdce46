// Which panel is seen at a point of the picture.

import { move } from './motion.js';
import { cross, dot, normalOf } from './vectors.js';

/** The panel at a point, from -1 to 1 across the picture and upwards; null where there is none. */
export function panelAt(across, upwards, solids, thickness, { poses, frame }) {
    const { right, up, back, position, high, wide } = frame;
    const ray = right.map((_, i) => across * wide * right[i] + upwards * high * up[i] - back[i]);
    let nearest = Infinity;
    let found = null;
    for (const { panel, points } of solids) {
        for (const z of [0, thickness]) {
            const corners = points.map(([x, y]) => {
                const out = [0, 0, 0];
                move(poses, 12 * panel, x, y, z, out, 0);
                return out.map((place, i) => place - position[i]);
            });
            const normal = normalOf(corners);
            const along = dot(corners[0], normal) / dot(ray, normal);
            if (along > 0 && along < nearest && isInside(ray, corners)) {
                nearest = along;
                found = panel;
            }
        }
    }
    return found;
}

/** Whether a ray from the origin meets a convex polygon: it passes all its edges on the same side. */
function isInside(ray, corners) {
    const sides = corners.map((corner, k) => dot(ray, cross(corner, corners[(k + 1) % corners.length])));
    return sides.every((side) => side >= 0) || sides.every((side) => side <= 0);
}
