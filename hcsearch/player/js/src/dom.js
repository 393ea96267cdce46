// Elements, and words for numbers.

/** An element with properties, or attributes where a name has a hyphen or is `role`, and children. */
export function element(tag, properties = {}, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(properties)) {
        if (name.includes('-') || name === 'role') made.setAttribute(name, value);
        else made[name] = value;
    }
    made.append(...children);
    return made;
}

const SHAPES = {
    play: 'M5 3v18l16-9z',
    pause: 'M5 3h5v18h-5zM14 3h5v18h-5z',
    again: 'M12 4V0L5 6l7 6V8a5.5 5.5 0 1 1-5.5 5.5H3A9 9 0 1 0 12 4z',
};

export function icon(name) {
    const space = 'http://www.w3.org/2000/svg';
    const svg = document.createElementNS(space, 'svg');
    svg.setAttribute('viewBox', '0 0 24 24');
    svg.setAttribute('aria-hidden', 'true');
    const path = document.createElementNS(space, 'path');
    path.setAttribute('d', SHAPES[name]);
    svg.append(path);
    return svg;
}

/** A length in mm with digits that fit it. */
export function millimetres(length) {
    const size = Math.abs(length);
    return `${length.toFixed(size < 0.1 ? 3 : size < 10 ? 2 : 1)}\u00a0mm`;
}

export function placeText(motion, at) {
    if (motion.payload.axis === 'path') return `${(100 * at).toFixed(1)} %`;
    const digits = 3 - Math.ceil(Math.log10(Math.max(motion.end, 1e-9)) - 1e-9);
    return `${at.toFixed(Math.min(9, Math.max(0, digits)))} s`;
}

export function nearestText(motion, at) {
    const { pair, gap, touching } = motion.nearestAt(at);
    const names = motion.payload.labels.panels;
    const touch = touching === 0 ? '' : touching === 1 ? '; 1 pair touches' : `; ${touching} pairs touch`;
    if (!pair) return touching ? `${touching} pairs of panels touch` : '';
    const two = `panels ${names[pair[0]]} and ${names[pair[1]]}`;
    return gap < 0
        ? `${two} overlap by ${millimetres(-gap)}${touch}`
        : `nearest: ${two}, ${millimetres(gap)} apart${touch}`;
}

/** How much slower than in reality a motion plays, or faster, where it takes some seconds on the screen. */
export function paceText({ payload, begin, end }, seconds) {
    if (payload.axis !== 'time' || end <= begin) return '';
    const ratio = seconds / (end - begin);
    const rounded = (x) => String(Number(x.toPrecision(2)));
    return ratio >= 1 ? `${rounded(ratio)} times slower than real` : `${rounded(1 / ratio)} times faster than real`;
}

/** Which panels have collided at a place, and when; empty before, and where none do. */
export function clashText(motion, at) {
    const { collision, labels } = motion.payload;
    if (!collision || at < collision[0]) return '';
    const [when, one, two] = collision;
    return `panels ${labels.panels[one]} and ${labels.panels[two]} collided at ${placeText(motion, when)}`;
}

/** An angle in degrees, rounded up to two digits. */
export function degreesAtMost(angle) {
    const degrees = (180 / Math.PI) * angle;
    const step = 10 ** (Math.floor(Math.log10(Math.max(degrees, 1e-9))) - 1);
    return `${Number((Math.ceil(degrees / step - 1e-9) * step).toPrecision(2))}°`;
}
