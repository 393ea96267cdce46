// Dragging, pinching, scrolling and keys on the picture.

const TURN = Math.PI / 18; // by a key

/** Listen on the stage and on the whole player; `does` : what each of them calls. */
export function gestures(stage, root, does) {
    const fingers = new Map();
    let spread = 0;

    stage.addEventListener('pointerdown', (event) => {
        does.wake();
        stage.setPointerCapture(event.pointerId);
        fingers.set(event.pointerId, [event.clientX, event.clientY]);
        spread = 0;
    });
    stage.addEventListener('pointermove', (event) => {
        const last = fingers.get(event.pointerId);
        if (!last) {
            const { left, top, width, height } = stage.getBoundingClientRect();
            does.point((2 * (event.clientX - left)) / width - 1, 1 - (2 * (event.clientY - top)) / height);
            return;
        }
        fingers.set(event.pointerId, [event.clientX, event.clientY]);
        const [right, down] = [event.clientX - last[0], event.clientY - last[1]];
        if (fingers.size === 1 && !event.shiftKey && event.buttons !== 2) {
            does.orbit(-0.009 * right, 0.009 * down);
            return;
        }
        // each of two fingers shifts the picture by half
        const share = 1 / (fingers.size * stage.clientHeight);
        does.pan(share * right, -share * down);
        if (fingers.size === 2) {
            const [[x, y], [toX, toY]] = fingers.values();
            const now = Math.hypot(toX - x, toY - y);
            if (spread > 0) does.zoom(now / spread);
            spread = now;
        }
    });
    stage.addEventListener('pointerleave', () => does.point(null));
    stage.addEventListener('contextmenu', (event) => event.preventDefault());
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) {
        stage.addEventListener(end, (event) => fingers.delete(event.pointerId));
    }
    // the page scrolls unless the reader is at the picture
    stage.addEventListener(
        'wheel',
        (event) => {
            const here = stage.getRootNode().activeElement === stage;
            if (!here && !event.ctrlKey) return;
            event.preventDefault();
            does.zoom(Math.exp(-0.0015 * event.deltaY * (event.deltaMode ? 30 : 1)));
        },
        { passive: false },
    );
    root.addEventListener('keydown', (event) => {
        if (event.altKey || event.ctrlKey || event.metaKey) return;
        const field = event.target.closest('button, select, input');
        const act = {
            ' ': does.toggle,
            ArrowRight: () => (event.shiftKey ? does.orbit(TURN, 0) : does.step(0.01)),
            ArrowUp: () => (event.shiftKey ? does.orbit(0, TURN) : does.step(0.01)),
            ArrowLeft: () => (event.shiftKey ? does.orbit(-TURN, 0) : does.step(-0.01)),
            ArrowDown: () => (event.shiftKey ? does.orbit(0, -TURN) : does.step(-0.01)),
            PageUp: () => does.step(0.1),
            PageDown: () => does.step(-0.1),
            Home: () => does.jump(0),
            End: () => does.jump(1),
            '+': () => does.zoom(1.25),
            '=': () => does.zoom(1.25),
            '-': () => does.zoom(0.8),
            0: does.reset,
        }[event.key];
        if (!act || field?.matches('select') || (field?.matches('button, input[type=checkbox]') && event.key === ' '))
            return;
        event.preventDefault();
        act();
    });
}
