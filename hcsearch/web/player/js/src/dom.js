// Elements and icons.

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
