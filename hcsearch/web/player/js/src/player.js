// The folding player: hcsearchPlayer.mount(element, payload, options) shows a motion in an element.
//
// Options: colour ('stack', 'panel' or 'nearest'), numbers (whether panels have theirs), autoplay (unless the reader
// prefers less motion), loop (whether it begins again at its end), exploded (whether panels are drawn apart), at (where
// it starts), theme ('light', 'dark', or 'auto'), fill (whether the picture takes the height that is left in the
// element), moved (called with each place that is drawn), pointed (called with the panel under the pointer, or null),
// parted (called with the choice of its reader whether panels are drawn apart).

import { View } from './camera.js';
import { facetColours } from './colours.js';
import { controlsOf, MODES, SECONDS } from './controls.js';
import { element } from './dom.js';
import { explodedView } from './exploded.js';
import { gestures } from './gestures.js';
import { markHinges } from './marks.js';
import { Motion } from './motion.js';
import { flatPainter } from './painter.js';
import { panelAt } from './picking.js';
import { solidsOf } from './solids.js';
import { STYLE } from './style.js';
import { webglPainter } from './webgl.js';
import { nearestText, pictureName, placeText } from './words.js';

const STILLS = [0, 0.25, 0.5, 0.75, 1];
const REST = 1; // seconds at the end before a motion begins again
const SAVED_WIDTH = 1600; // of a saved picture, pixels
const KEPT = 10000; // milliseconds until a saved picture is forgotten
let playing = null; // one player of a page plays at a time
let sheet;

function mount(place, payload, options = {}) {
    const motion = new Motion(typeof payload === 'string' ? JSON.parse(payload) : payload);
    const solids = solidsOf(motion.payload);
    const labels = facetLabels(motion.payload, solids);
    const view = new View(motion, solids);
    const explode = explodedView(motion, solids);
    const dark = matchMedia('(prefers-color-scheme: dark)');
    const calm = matchMedia('(prefers-reduced-motion: reduce)').matches;
    const state = {
        at: options.at ?? motion.begin,
        speed: 1,
        mode: options.colour ?? (motion.payload.stack ? 'stack' : 'panel'),
        numbers: options.numbers ?? false,
        loop: options.loop ?? false,
        exploded: options.exploded ?? false,
        marked: { panels: [], hinges: [] },
    };
    let painter = null;
    let waiting = 0;
    let last = 0;
    let rested = 0;
    let under = null;
    let gone = false;

    const length = motion.end - motion.begin;
    const posesAt = (at) => (state.exploded ? explode(motion.posesAt(at)) : motion.posesAt(at));
    const within = (at) => Math.min(motion.end, Math.max(motion.begin, at));
    const does = {
        toggle: () => (playing === handle ? handle.pause() : handle.play()),
        seek: (share) => handle.seek(motion.begin + share * length),
        step: (share) => handle.seek(state.at + share * length),
        jump: (share) => handle.seek(motion.begin + share * length),
        speed: (x) => handle.setSpeed(x),
        colour: (mode) => handle.colourBy(mode),
        numbers: (shown) => redraw({ numbers: shown }),
        loop: (again) => redraw({ loop: again }),
        explode: (apart) => {
            redraw({ exploded: apart });
            view.fit(posesAt);
            options.parted?.(apart);
        },
        save,
        look: (name) => {
            view.look(name);
            redraw();
        },
        point: (across, upwards) => {
            const poses = posesAt(state.at);
            const { clientWidth, clientHeight } = controls.stage;
            const seen = { poses, frame: view.frame(clientWidth / clientHeight, poses) };
            const thickness = motion.payload.unit * motion.payload.thickness;
            point(across === null ? null : panelAt(across, upwards, solids, thickness, seen));
        },
        wake: () => controls.stage.focus({ preventScroll: true }),
        orbit: (turn, lift) => {
            view.orbit(turn, lift);
            redraw();
        },
        pan: (right, up) => {
            view.pan(right, up);
            redraw();
        },
        zoom: (factor) => {
            view.zoomBy(factor);
            redraw();
        },
        reset: () => {
            view.reset();
            redraw();
        },
    };
    const controls = controlsOf(motion, does, state);
    view.fit(posesAt);
    gestures(controls.stage, controls.root, does);
    controls.root.classList.toggle('fill', options.fill ?? false);
    const host = element('div', { className: options.fill ? 'fill' : '' });
    const shadow = host.attachShadow({ mode: 'open' });
    shadow.adoptedStyleSheets = [styleSheet()];
    shadow.append(controls.root);

    function theme() {
        return options.theme === 'light' || options.theme === 'dark' ? options.theme : dark.matches ? 'dark' : 'light';
    }

    function painterNow() {
        if (painter?.lost) {
            painter = null;
        }
        if (!painter) {
            painter = webglPainter(motion, solids, labels, view.along);
            if (!painter) {
                painter = flatPainter(motion, solids, labels);
                controls.note.textContent =
                    'This browser shows no WebGL: the picture is drawn without it, and panels that lie close may hide each other wrongly.';
                controls.note.hidden = false;
            }
        }
        return painter;
    }

    /** Draw a state onto a canvas of some size in pixels. */
    function paint(canvas, at, width, height, look = {}) {
        canvas.width = width;
        canvas.height = height;
        const { mode, numbers } = { ...state, ...look };
        const marked = new Map();
        const { collision } = motion.payload;
        state.marked.panels.forEach((panel) => marked.set(panel, 'near'));
        if (mode === 'nearest') motion.nearestAt(at).pair?.forEach((panel) => marked.set(panel, 'near'));
        if (collision && at >= collision[0]) collision.slice(1).forEach((panel) => marked.set(panel, 'clash'));
        const shade = look.theme ?? theme();
        const poses = posesAt(at);
        const seen = { poses, frame: view.frame(width / height, poses), theme: shade };
        const context = canvas.getContext('2d');
        const colours = facetColours(motion.payload, mode, shade, marked);
        painterNow().paint(context, width, height, { ...seen, colours, numbers });
        markHinges(context, motion, state.marked.hinges, seen);
    }

    function point(panel) {
        if (panel === under) return;
        under = panel;
        options.pointed?.(panel);
    }

    /** Save what is seen as a file of its own. */
    function save() {
        const canvas = element('canvas');
        const { clientWidth, clientHeight } = controls.stage;
        paint(canvas, state.at, SAVED_WIDTH, Math.round((SAVED_WIDTH * clientHeight) / clientWidth));
        canvas.toBlob((blob) => {
            const href = URL.createObjectURL(blob);
            element('a', { href, download: pictureName(motion, state.at) }).click();
            setTimeout(() => URL.revokeObjectURL(href), KEPT); // some browsers read it only later
        });
    }

    function draw() {
        waiting = 0;
        if (gone) return;
        const { clientWidth, clientHeight } = controls.stage;
        controls.root.classList.toggle('dark', theme() === 'dark');
        controls.show(state.at, playing === handle);
        if (clientWidth && clientHeight) {
            const dots = Math.min(2, window.devicePixelRatio || 1);
            paint(controls.canvas, state.at, Math.round(dots * clientWidth), Math.round(dots * clientHeight));
        }
        options.moved?.(state.at);
    }

    function redraw(change = {}) {
        Object.assign(state, change);
        if (!waiting) waiting = requestAnimationFrame(draw);
    }

    function frame(now) {
        if (playing !== handle || gone) return;
        // a page that was not seen for a while goes on where it was
        const passed = Math.min(0.1, (now - (last || now)) / 1000);
        const at = state.at + passed * (state.speed / SECONDS) * length;
        last = now;
        state.at = within(at);
        if (at >= motion.end) {
            rested += passed;
            if (!state.loop) playing = null;
            else if (rested >= REST) state.at = motion.begin;
        } else rested = 0;
        draw();
        if (playing === handle) requestAnimationFrame(frame);
    }

    const handle = {
        play() {
            if (playing === handle || gone) return;
            playing?.pause();
            if (state.at >= motion.end) state.at = motion.begin;
            playing = handle;
            last = 0;
            requestAnimationFrame(frame);
        },
        pause() {
            if (playing === handle) playing = null;
            redraw();
        },
        seek(at) {
            redraw({ at: within(Number(at)) });
        },
        setSpeed(factor) {
            state.speed = Number(factor);
            controls.setPace(state.speed);
        },
        colourBy(mode) {
            if (!Object.keys(MODES).includes(mode)) throw new Error(`panels have no colours by ${mode}`);
            controls.colourings.value = mode;
            redraw({ mode });
        },
        /** Point out panels, in a colour, and hinges, by lines; both by their numbers in the payload. */
        mark({ panels = [], hinges = [] }) {
            redraw({ marked: { panels, hinges } });
        },
        still(at, width, height) {
            const canvas = element('canvas');
            paint(canvas, within(at), width, height);
            return canvas.toDataURL();
        },
        dispose() {
            handle.pause();
            gone = true;
            cancelAnimationFrame(waiting);
            listening.abort();
            resized.disconnect();
            painter?.dispose();
            host.remove();
        },
        get at() {
            return state.at;
        },
        get playing() {
            return playing === handle;
        },
    };

    /** Five stills take the place of the picture on paper, which is white. */
    function stills() {
        const figures = STILLS.map((share) => {
            const at = motion.begin + share * length;
            const canvas = element('canvas', { role: 'img', 'aria-label': `The state at ${placeText(motion, at)}` });
            paint(canvas, at, 480, 400, { theme: 'light' });
            return element(
                'figure',
                {},
                canvas,
                element('figcaption', { textContent: `${placeText(motion, at)}, ${nearestText(motion, at)}` }),
            );
        });
        controls.stills.replaceChildren(...figures);
        controls.root.classList.remove('dark');
    }

    const listening = new AbortController();
    const { signal } = listening;
    dark.addEventListener('change', () => redraw(), { signal });
    window.addEventListener('beforeprint', stills, { signal });
    window.addEventListener('afterprint', () => redraw(), { signal });
    const resized = new ResizeObserver(() => redraw());
    resized.observe(controls.stage);
    place.append(host);
    draw();
    if (options.autoplay && !calm) handle.play();
    return handle;
}

/** What is written on each facet: its own number where a panel names several, else the panel's on its widest facet. */
function facetLabels({ labels }, solids) {
    const written = solids.map(() => '');
    labels.panels.forEach((label, p) => {
        const own = solids.flatMap((solid, f) => (solid.panel === p ? [f] : []));
        const parts = label.split('+');
        if (parts.length === own.length) own.forEach((f, k) => (written[f] = parts[k]));
        else written[own.reduce((best, f) => (solids[f].reach > solids[best].reach + 1e-9 ? f : best))] = label;
    });
    return written;
}

function styleSheet() {
    if (!sheet) {
        sheet = new CSSStyleSheet();
        sheet.replaceSync(STYLE);
    }
    return sheet;
}

/** Poses of the panels at a place: 12 numbers a panel, rotation by rows and translation in mm. */
function poses(payload, at) {
    return new Motion(payload).posesAt(at);
}

globalThis.hcsearchPlayer = { mount, poses };
