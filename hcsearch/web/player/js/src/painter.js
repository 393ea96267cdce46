// The same picture without WebGL: polygons on a 2D canvas, the farthest first.

import { projection } from './camera.js';
import { kindColour, THEMES } from './colours.js';
import { move } from './motion.js';
import { dot, normalOf, unitVector } from './vectors.js';
import { writeNumber } from './words.js';

const KEY = unitVector([-0.35, 0.75, 0.6]);

export function flatPainter(motion, solids, labels) {
    const thickness = motion.payload.unit * motion.payload.thickness;
    return {
        lost: false,

        paint(context, width, height, { poses, frame, colours, theme, numbers }) {
            const { right, up, back, position } = frame;
            const scale = height / (2 * frame.high);
            const seen = projection(frame, width, height);
            const drawn = [];
            solids.forEach((solid, f) => {
                for (const { corners, kind } of solid.polygons) {
                    const placed = corners.map(([x, y, z]) => {
                        const out = [0, 0, 0];
                        move(poses, 12 * solid.panel, x, y, z, out, 0);
                        return out;
                    });
                    const normal = normalOf(placed);
                    const spot = placed[0].map((x, i) => position[i] - x);
                    if (dot(normal, spot) <= 0) continue;
                    const points = placed.map(seen);
                    const depth = points.reduce((sum, p) => sum + p[2], 0) / points.length;
                    const light = [dot(normal, right), dot(normal, up), dot(normal, back)];
                    const share = Math.min(1, 0.6 + 0.45 * Math.max(0, dot(light, KEY)));
                    const colour = kindColour(kind, colours[f], theme).map((x) => Math.round(255 * share * x));
                    drawn.push({
                        points,
                        depth,
                        colour: `rgb(${colour.join(',')})`,
                        label: numbers && kind < 2 && Math.abs(light[2]) > 0.35 ? labels[f] : '',
                        solid,
                        kind,
                    });
                }
            });
            drawn.sort((a, b) => b.depth - a.depth);
            context.clearRect(0, 0, width, height);
            context.lineWidth = 0.6;
            for (const { points, colour, label, solid, kind, depth } of drawn) {
                context.fillStyle = context.strokeStyle = colour;
                context.beginPath();
                points.forEach(([x, y]) => context.lineTo(x, y));
                context.closePath();
                context.fill();
                context.stroke();
                if (!label) continue;
                const out = [0, 0, 0];
                move(poses, 12 * solid.panel, ...solid.middle, kind === 0 ? thickness : 0, out, 0);
                const [x, y] = seen(out);
                context.fillStyle = THEMES[theme].text;
                writeNumber(context, label, x, y, (0.7 * scale * solid.reach) / depth);
            }
        },

        dispose() {},
    };
}
