// The exploded view: panels drawn apart, so that the faces and hinges between stacked panels are seen.

import { move } from './motion.js';

const BETWEEN = 3; // thicknesses between panels that are packed on each other
const ACROSS = 0.35; // by which distances within the layers grow

/** The map from poses of a motion to the same poses with the panels apart: each is shifted from the middle of all. */
export function explodedView(motion, solids) {
    const { unit, thickness, order } = motion.payload;
    const centres = order.map((_, panel) => centreOf(solids.filter((solid) => solid.panel === panel)));
    // the panel that is held has the pose 1, so that the layers lie along z while the array is packed or flat
    const height = (places) => Math.max(...places.map((place) => place[2])) - Math.min(...places.map((place) => place[2]));
    const packed = Math.max(unit * thickness, height(placesOf(motion.posesAt(motion.begin))));

    function placesOf(poses) {
        return centres.map(([x, y], panel) => {
            const place = [0, 0, 0];
            move(poses, 12 * panel, x, y, 0.5 * unit * thickness, place, 0);
            return place;
        });
    }

    return (poses) => {
        const places = placesOf(poses);
        const middle = [0, 1, 2].map((i) => places.reduce((sum, place) => sum + place[i], 0) / places.length);
        // panels that stand up in between are not taken farther apart than packed ones
        const along = BETWEEN * Math.min(1, packed / height(places));
        const shifted = Float64Array.from(poses);
        places.forEach((place, panel) =>
            [ACROSS, ACROSS, along].forEach((share, i) => {
                shifted[12 * panel + 4 * i + 3] += share * (place[i] - middle[i]);
            }),
        );
        return shifted;
    };
}

function centreOf(facets) {
    return [0, 1].map((i) => facets.reduce((sum, { middle }) => sum + middle[i], 0) / facets.length);
}
