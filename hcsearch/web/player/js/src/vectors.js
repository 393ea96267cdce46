export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
];

export function unitVector(vector) {
    const length = Math.hypot(...vector) || 1;
    return vector.map((x) => x / length);
}

/** The normal of a polygon, by Newell's sum: towards where its corners run counterclockwise. */
export function normalOf(corners) {
    const sum = [0, 0, 0];
    corners.forEach(([x, y, z], k) => {
        const [a, b, c] = corners[(k + 1) % corners.length];
        sum[0] += (y - b) * (z + c);
        sum[1] += (z - c) * (x + a);
        sum[2] += (x - a) * (y + b);
    });
    return unitVector(sum);
}
