// A motion from its plain data: fold angles between key states, and where they put the panels. Lengths in mm.

export class Motion {
    constructor(payload) {
        if (payload.version !== 1) throw new Error(`a motion of version ${payload.version} cannot be shown`);
        this.payload = payload;
        this.at = Float64Array.from(payload.at);
        this.begin = this.at[0];
        this.end = this.at[this.at.length - 1];
        this.hinges = payload.hinges.length;
        this.panels = payload.order.length;
        this.keys = anglesIn(payload);
        this.angles = new Float64Array(this.hinges);
        this.lines = payload.hinges.map((hinge) => lineOf(hinge, payload));
    }

    /** The number of the last key state that is not after a place, and the share of the way to the next. */
    locate(at) {
        let low = 0;
        let high = this.at.length - 1;
        if (high === 0 || at <= this.begin) return [0, 0];
        if (at >= this.end) return [high - 1, 1];
        while (high - low > 1) {
            const middle = (low + high) >> 1;
            if (this.at[middle] <= at) low = middle;
            else high = middle;
        }
        return [low, (at - this.at[low]) / (this.at[high] - this.at[low])];
    }

    anglesAt(at) {
        const [key, share] = this.locate(at);
        const next = Math.min(key + 1, this.at.length - 1);
        for (let h = 0; h < this.hinges; h++) {
            const from = this.keys[key * this.hinges + h];
            this.angles[h] = from + share * (this.keys[next * this.hinges + h] - from);
        }
        return this.angles;
    }

    /** Poses of the panels: a rotation by rows and a translation, 12 numbers a panel. */
    posesAt(at) {
        const angles = this.anglesAt(at);
        const { order, parents, via, signs } = this.payload;
        const poses = new Float64Array(12 * this.panels);
        for (const panel of order) {
            const pose = poses.subarray(12 * panel, 12 * panel + 12);
            const parent = parents[panel];
            if (parent < 0) {
                pose[0] = pose[5] = pose[10] = 1;
                continue;
            }
            pose.set(poses.subarray(12 * parent, 12 * parent + 12));
            turn(pose, this.lines[via[panel]], signs[panel] * angles[via[panel]]);
        }
        return poses;
    }

    /** The nearest pair of panels at a place: `pair` (null where all touch), `gap` in mm, and how many pairs touch. */
    nearestAt(at) {
        const { nearest, gaps, touching, unit } = this.payload;
        const [key, share] = this.locate(at);
        const next = Math.min(key + 1, this.at.length - 1);
        const near = share < 0.5 ? key : next;
        const pair = [nearest[2 * near], nearest[2 * near + 1]];
        if (pair[0] < 0) return { pair: null, gap: 0, touching: touching[near] };
        const same = nearest[2 * key] === nearest[2 * next] && nearest[2 * key + 1] === nearest[2 * next + 1];
        const gap = same ? gaps[key] + share * (gaps[next] - gaps[key]) : gaps[near];
        return { pair, gap: 0.1 * unit * gap, touching: touching[near] };
    }
}

/** The pose's image of a point, into an array. */
export function move(pose, offset, x, y, z, out, to) {
    for (let i = 0; i < 3; i++) {
        const row = offset + 4 * i;
        out[to + i] = pose[row] * x + pose[row + 1] * y + pose[row + 2] * z + pose[row + 3];
    }
}

function anglesIn({ angles, scale }) {
    const bytes = Uint8Array.from(atob(angles), (mark) => mark.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Float64Array.from({ length: bytes.length / 2 }, (_, k) => scale * view.getInt16(2 * k, true));
}

function lineOf([x, y, toX, toY, top], { unit, thickness }) {
    const length = Math.hypot(toX - x, toY - y);
    const sign = top ? -1 : 1;
    return {
        direction: [(sign * (toX - x)) / length, (sign * (toY - y)) / length],
        point: [0.5 * unit * (x + toX), 0.5 * unit * (y + toY), top ? unit * thickness : 0],
    };
}

/** Multiply a pose by the turn about a line of the flat state, from the right. */
function turn(pose, { direction: [u, v], point: [px, py, pz] }, angle) {
    const s = Math.sin(angle);
    const c = 1 - Math.cos(angle);
    const rotation = [1 - c * v * v, c * u * v, s * v, c * u * v, 1 - c * u * u, -s * u, -s * v, s * u, 1 - c];
    for (let i = 0; i < 12; i += 4) {
        const [a, b, d] = [pose[i], pose[i + 1], pose[i + 2]];
        for (let j = 0; j < 3; j++) pose[i + j] = a * rotation[j] + b * rotation[3 + j] + d * rotation[6 + j];
        pose[i + 3] += (a - pose[i]) * px + (b - pose[i + 1]) * py + (d - pose[i + 2]) * pz;
    }
}
