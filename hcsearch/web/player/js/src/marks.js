// Hinges that are pointed out: lines over the picture, so that they are seen behind panels, too.

import { projection } from './camera.js';
import { THEMES } from './colours.js';
import { move } from './motion.js';

/** Draw the lines of some hinges onto a picture that shows their panels in the same state. */
export function markHinges(context, { payload }, hinges, { poses, frame, theme }) {
    const { width, height } = context.canvas;
    const seen = projection(frame, width, height);
    const size = Math.max(3, 0.012 * Math.min(width, height));
    for (const hinge of hinges) {
        const [x, y, toX, toY, top, , panel] = payload.hinges[hinge];
        const ends = [
            [x, y],
            [toX, toY],
        ].map((end) => {
            const out = [0, 0, 0];
            const [flatX, flatY] = end.map((value) => payload.unit * value);
            move(poses, 12 * panel, flatX, flatY, top ? payload.unit * payload.thickness : 0, out, 0);
            return seen(out);
        });
        for (const [colour, wide] of [
            [THEMES[theme].text, 2.2 * size],
            [THEMES[theme].near, 1.4 * size],
        ]) {
            context.strokeStyle = colour;
            context.lineWidth = wide;
            context.lineCap = 'round';
            context.beginPath();
            ends.forEach(([across, down]) => context.lineTo(across, down));
            context.stroke();
        }
    }
}
