// Words for numbers, and for what happens at a place of a motion.

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

/** The name of a file for a picture of a state. */
export function pictureName(motion, at) {
    const text = `${motion.payload.title} ${placeText(motion, at)}`;
    return `${text.replace(/[^\p{L}\p{N}.]+/gu, '-').replace(/^-|-$/g, '')}.png`;
}

/** Write a panel's number about a point; a line under 6 and 9 shows which way up they are. */
export function writeNumber(context, text, x, y, size) {
    context.font = `600 ${size}px system-ui, sans-serif`;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.fillText(text, x, y + 0.06 * size);
    if (!/[69]/.test(text)) return;
    const width = context.measureText(text).width;
    context.fillRect(x - width / 2, y + 0.5 * size, width, 0.09 * size);
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
