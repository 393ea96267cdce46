// Colours of panels in each mode, and of all else, on a light and on a dark page.

import { KINDS } from './solids.js';

const HINGES = { mountain: '#d1202f', valley: '#1c5fd4', flat: '#6a4fc0' };
const HINGES_DARK = { mountain: '#ff5c5c', valley: '#5b9dff', flat: '#a690f2' };

export const THEMES = {
    light: {
        ...HINGES,
        cut: '#343a46',
        slit: '#20242e',
        grey: '#c9ced6',
        near: '#f0a63a',
        clash: '#e2574c',
        text: '#20242e',
    },
    dark: {
        ...HINGES_DARK,
        cut: '#2a2f39',
        slit: '#14171c',
        grey: '#8d96a5',
        near: '#ffb84d',
        clash: '#ff6a5e',
        text: '#14171c',
    },
};

const STACKS = { light: ['#eadfc3', '#a9d3c6'], dark: ['#cfc3a2', '#7fb3a4'] };

/** Red, green, blue from 0 to 1 of a colour written #rrggbb. */
export function rgb(text) {
    return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255);
}

/** The colour of each facet in a mode; `marked` : panels that are marked, and how, by the name of a theme's colour. */
export function facetColours(payload, mode, theme, marked) {
    const { panel, stack } = payload;
    return panel.map((p, f) => {
        const mark = marked.get(p);
        if (mark) return rgb(THEMES[theme][mark]);
        if (mode === 'nearest') return rgb(THEMES[theme].grey);
        if (mode === 'stack' && stack) return rgb(STACKS[theme][stack[f]]);
        return hue(p, theme);
    });
}

/** Colours of equal lightness, those of panels that follow each other far apart (Ottosson's Oklch). */
function hue(number, theme) {
    const [light, chroma] = theme === 'dark' ? [0.74, 0.075] : [0.86, 0.075];
    const angle = 1.3 + number * Math.PI * (3 - Math.sqrt(5));
    const [a, b] = [chroma * Math.cos(angle), chroma * Math.sin(angle)];
    const l = (light + 0.3963377774 * a + 0.2158037573 * b) ** 3;
    const m = (light - 0.1055613458 * a - 0.0638541728 * b) ** 3;
    const s = (light - 0.0894841775 * a - 1.291485548 * b) ** 3;
    return [
        4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
        -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
    ].map((x) => Math.min(1, Math.max(0, x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055)));
}

/** The colour of a polygon by its kind, of a facet's colour. */
export function kindColour(kind, facet, theme) {
    const name = KINDS[kind];
    const share = { top: 1, bottom: 0.88, wall: 0.6, rim: 0.8 }[name];
    return share === undefined ? rgb(THEMES[theme][name]) : facet.map((x) => share * x);
}
