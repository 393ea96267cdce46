// The elements of a player, and what its reader does with them.

import { element, icon } from './dom.js';
import { clashText, degreesAtMost, millimetres, nearestText, paceText, placeText } from './words.js';

const STEPS = 1000;
export const SECONDS = 8; // that a motion takes to play
const SPEEDS = [0.25, 0.5, 1, 2, 4];
export const MODES = { stack: 'stack', panel: 'panel', nearest: 'nearest pair' };

/** All elements of a player, not yet in a page; `does` : what each control calls; after it, what is chosen at first. */
export function controlsOf(motion, does, { mode, numbers, loop, exploded }) {
    const { payload } = motion;
    const keys =
        'Drag to turn, with Shift or two fingers to shift, pinch or scroll to zoom. Space plays, arrow keys step, with Shift they turn the picture, ' +
        'Home and End jump, plus and minus zoom, 0 resets the view.';
    const canvas = element('canvas', { 'aria-hidden': 'true' });
    const [near, clash] = [element('span'), element('strong')];
    const tag = element('p', { className: 'tag' }, clash, near);
    const small = (text, label, act) =>
        element('button', { type: 'button', textContent: text, title: label, 'aria-label': label, onclick: act });
    const corner = element(
        'div',
        { className: 'corner' },
        small('+', 'Zoom in', () => does.zoom(1.25)),
        small('\u2212', 'Zoom out', () => does.zoom(0.8)),
        small('\u27f2', 'Reset the view', does.reset),
    );
    const about = {
        role: 'application',
        'aria-roledescription': 'picture',
        'aria-label': `${payload.title} in space. ${keys}`,
    };
    const stage = element('div', { className: 'stage', tabIndex: 0, ...about }, canvas);
    const go = element('button', { className: 'go', type: 'button', onclick: does.toggle });
    const range = element('input', {
        type: 'range',
        min: 0,
        max: STEPS,
        step: 1,
        value: 0,
        'aria-label': 'Place in the motion, from packed to flat',
    });
    range.addEventListener('input', () => does.seek(range.value / STEPS));
    const place = element('span', { className: 'place' });
    const slider = element('div', { className: 'slider' }, trackOf(motion), range);
    const choice = (label, options, value, act) => {
        const select = element(
            'select',
            { onchange: () => act(select.value) },
            ...options.map(([key, text]) => element('option', { value: key, textContent: text })),
        );
        select.value = value;
        return [element('label', {}, label, select), select];
    };
    const [speed, speeds] = choice(
        'Speed',
        SPEEDS.map((x) => [x, `${x}\u00d7`]),
        1,
        (x) => does.speed(Number(x)),
    );
    const modes = Object.entries(MODES).filter(([name]) => name !== 'stack' || payload.stack);
    const [colours, colourings] = choice('Colour by', modes, mode, does.colour);
    const check = (label, checked, act) => {
        const box = element('input', { type: 'checkbox', checked, onchange: () => act(box.checked) });
        return element('label', {}, box, label);
    };
    const look = (text, name, from) => small(text, `Look ${from}`, () => does.look(name));
    const looks = element(
        'div',
        { className: 'looks', role: 'group', 'aria-label': 'View' },
        look('Top', 'top', 'from the top'),
        look('Front', 'front', 'from the front'),
        look('Side', 'side', 'from the side'),
    );
    const saving = element('button', { type: 'button', textContent: 'Save picture', onclick: does.save });
    const pace = element('span');
    const setPace = (factor) => {
        speeds.value = String(factor);
        pace.textContent = paceText(motion, SECONDS / factor);
    };
    setPace(1);
    speed.append(pace);
    const tools = element(
        'div',
        { className: 'tools' },
        speed,
        check('Loop', loop, does.loop),
        colours,
        check('Panel numbers', numbers, does.numbers),
        check('Exploded view', exploded, does.explode),
        looks,
        saving,
    );
    const stills = element('div', { className: 'stills' });
    const note = element('p', { className: 'source', hidden: true });
    const root = element(
        'div',
        { className: 'player', role: 'group', 'aria-label': `How ${payload.title} unfolds` },
        element('div', { className: 'view' }, stage, tag, corner),
        note,
        element('div', { className: 'bar' }, go, slider, place),
        tools,
        stills,
        keyOf(motion),
        element('p', { className: 'source', textContent: sourceOf(motion) }),
    );
    const shown = { shape: '' };
    return {
        root,
        stage,
        canvas,
        range,
        stills,
        setPace,
        colourings,
        note,

        show(at, playing) {
            const share = motion.end > motion.begin ? (at - motion.begin) / (motion.end - motion.begin) : 0;
            range.value = Math.round(STEPS * share);
            place.textContent = placeText(motion, at);
            range.setAttribute('aria-valuetext', `${placeText(motion, at)} of ${placeText(motion, motion.end)}`);
            near.textContent = nearestText(motion, at);
            clash.textContent = clashText(motion, at);
            const shape = playing ? 'pause' : share >= 1 ? 'again' : 'play';
            if (shape !== shown.shape) {
                shown.shape = shape;
                go.replaceChildren(icon(shape));
                go.setAttribute('aria-label', { pause: 'Pause', again: 'Play again', play: 'Play' }[shape]);
            }
        },
    };
}

/** The line under the slider: certified intervals in green, a collision as a red mark. */
function trackOf({ payload, begin, end }) {
    const share = (at) => `${(100 * (at - begin)) / (end - begin || 1)}%`;
    const track = element('div', { className: 'track' });
    for (const [from, to] of payload.certified) {
        const band = element('i');
        band.style.left = share(from);
        band.style.width = `calc(${share(to)} - ${share(from)})`;
        track.append(band);
    }
    if (payload.collision) {
        const mark = element('b');
        mark.style.left = share(payload.collision[0]);
        track.append(mark);
    }
    return track;
}

function keyOf(motion) {
    const { payload } = motion;
    const folds = new Set(
        payload.hinges.map(([, , , , top, closes]) => (closes ? (top ? 'valley' : 'mountain') : 'flat')),
    );
    const words = { mountain: 'mountain hinge', valley: 'valley hinge', flat: 'hinge that stays flat' };
    const entries = Object.entries(words).filter(([kind]) => folds.has(kind));
    entries.push(['slit', 'slit']);
    if (payload.certified.length)
        entries.push(['safe', `${certifiedText(motion)}, ${millimetres(payload.margin)} of play`]);
    if (payload.collision) entries.push(['clash', 'first collision']);
    return element(
        'ul',
        { className: 'key' },
        ...entries.map(([kind, text]) =>
            element('li', { className: `of-${kind}` }, element('i', { className: kind }), text),
        ),
    );
}

function certifiedText(motion) {
    const { certified } = motion.payload;
    const near = 1e-4 * (motion.end - motion.begin); // places of key states are rounded, those of intervals are not
    if (certified.length === 1 && certified[0][0] <= motion.begin + near && certified[0][1] >= motion.end - near)
        return 'certified clear throughout';
    return `certified clear from ${certified.map((ends) => ends.map((at) => placeText(motion, at)).join(' to ')).join(', ')}`;
}

function sourceOf(motion) {
    const { source, collision, labels, error } = motion.payload;
    const ended = (text) => (/[.!?]$/.test(text) ? text : `${text}.`);
    const sentences = [ended(source.charAt(0).toUpperCase() + source.slice(1))];
    if (collision) {
        const [at, one, two] = collision;
        sentences.push(`Panels ${labels.panels[one]} and ${labels.panels[two]} collide at ${placeText(motion, at)}.`);
    }
    sentences.push(
        `States between the ${motion.at.length} stored ones are interpolated; a hinge is off by ${degreesAtMost(error)} at most.`,
    );
    return sentences.join(' ');
}
