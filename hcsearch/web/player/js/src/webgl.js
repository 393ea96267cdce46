// The one WebGL canvas of a page: every player draws on it in turn, and keeps a copy of its own picture.

import { Camera } from 'ogl/src/core/Camera.js';
import { Geometry } from 'ogl/src/core/Geometry.js';
import { Mesh } from 'ogl/src/core/Mesh.js';
import { Program } from 'ogl/src/core/Program.js';
import { Renderer } from 'ogl/src/core/Renderer.js';
import { Texture } from 'ogl/src/core/Texture.js';
import { Transform } from 'ogl/src/core/Transform.js';
import { FIELD } from './camera.js';
import { kindColour, rgb, THEMES } from './colours.js';
import { KINDS } from './solids.js';
import { normalOf } from './vectors.js';
import { writeNumber } from './words.js';

const VERTEX = `
attribute vec3 position;
attribute vec3 normal;
attribute float kind;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform mat3 normalMatrix;
uniform vec3 palette[${KINDS.length}];
varying vec3 vNormal;
varying vec3 vColour;
varying vec3 vPlace;
void main() {
    vNormal = normalMatrix * normal;
    vColour = palette[int(kind + 0.5)];
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    vPlace = place.xyz;
    gl_Position = projectionMatrix * place;
}`;

// A key light over the shoulder, a sky and a ground, and a little gloss.
const FRAGMENT = `
precision highp float;
varying vec3 vNormal;
varying vec3 vColour;
varying vec3 vPlace;
void main() {
    vec3 n = normalize(vNormal);
    vec3 eye = normalize(-vPlace);
    vec3 key = normalize(vec3(-0.35, 0.75, 0.6));
    float sun = max(dot(n, key), 0.0);
    float fill = max(dot(n, normalize(vec3(0.7, -0.1, 0.6))), 0.0);
    float gloss = pow(max(dot(n, normalize(key + eye)), 0.0), 40.0);
    vec3 colour = pow(vColour, vec3(2.2));
    vec3 lit = colour * (0.36 + 0.1 * n.y + 0.55 * sun + 0.2 * fill + 0.14 * max(n.z, 0.0)) + 0.04 * gloss;
    gl_FragColor = vec4(pow(lit, vec3(1.0 / 2.2)), 1.0);
}`;

const TEXT_VERTEX = `
attribute vec3 position;
attribute vec2 uv;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
varying vec2 vUv;
void main() {
    vUv = uv;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const TEXT_FRAGMENT = `
precision highp float;
uniform sampler2D map;
uniform vec3 ink;
varying vec2 vUv;
void main() {
    float cover = texture2D(map, vUv).a;
    if (cover < 0.02) discard;
    gl_FragColor = vec4(ink * cover, cover);
}`;

let shared;

/** The page's canvas; null where there is no WebGL. */
function canvasOfPage() {
    if (shared === undefined) {
        const canvas = document.createElement('canvas');
        const wanted = { alpha: true, antialias: true, depth: true, premultipliedAlpha: true };
        const context = canvas.getContext('webgl2', wanted) ?? canvas.getContext('webgl', wanted);
        shared = null;
        if (context && !context.isContextLost()) {
            const webgl = context instanceof WebGLRenderingContext ? 1 : 2;
            shared = { renderer: new Renderer({ ...wanted, canvas, webgl }), lost: 0 };
            canvas.addEventListener('webglcontextlost', () => {
                shared.lost += 1;
            });
        }
    }
    return shared;
}

/** What draws a motion with WebGL; null where there is none. */
export function webglPainter(motion, solids, labels, upright) {
    const page = canvasOfPage();
    if (!page || page.renderer.gl.isContextLost()) return null;
    const born = page.lost;
    const { renderer } = page;
    const { gl } = renderer;
    const scene = new Transform();
    const camera = new Camera(gl);
    const palettes = solids.map(() => []);
    const program = new Program(gl, { vertex: VERTEX, fragment: FRAGMENT, uniforms: { palette: { value: [] } } });
    const meshes = solids.map((solid, f) => {
        const mesh = new Mesh(gl, { geometry: geometryOf(gl, solid.polygons), program, frustumCulled: false });
        mesh.matrixAutoUpdate = false;
        mesh.onBeforeRender(() => {
            program.uniforms.palette.value = palettes[f];
        });
        mesh.setParent(scene);
        return mesh;
    });
    const text = new Transform();
    const writing = textOf(gl, solids, labels, motion, upright);
    writing.meshes.forEach((mesh) => mesh.setParent(text));

    return {
        get lost() {
            return born !== page.lost || gl.isContextLost();
        },

        /** Draw a state onto a 2D context of the given size in pixels. */
        paint(context, width, height, { poses, frame, colours, theme, numbers }) {
            solids.forEach((solid, f) => {
                palettes[f] = KINDS.flatMap((_, kind) => kindColour(kind, colours[f], theme));
                place(meshes[f], poses, solid.panel);
                place(writing.meshes[f], poses, solid.panel);
            });
            writing.program.uniforms.ink.value = rgb(THEMES[theme].text);
            text.setParent(numbers ? scene : null);
            camera.perspective({
                fov: (180 / Math.PI) * FIELD,
                aspect: width / height,
                near: frame.near,
                far: frame.far,
            });
            const look = frame.position.map((x, i) => x - frame.back[i]);
            camera.up.set(...frame.up);
            camera.position.set(...frame.position);
            camera.lookAt(look);
            renderer.dpr = 1;
            renderer.setSize(width, height);
            gl.clearColor(0, 0, 0, 0);
            renderer.render({ scene, camera, sort: true, frustumCull: false });
            context.clearRect(0, 0, width, height);
            context.drawImage(gl.canvas, 0, 0, width, height);
        },

        dispose() {
            [...meshes, ...writing.meshes].forEach((mesh) => mesh.geometry.remove());
            program.remove();
            writing.program.remove();
            gl.deleteTexture(writing.map.texture);
        },
    };
}

function place(mesh, poses, panel) {
    const p = poses.subarray(12 * panel, 12 * panel + 12);
    mesh.worldMatrixNeedsUpdate = true;
    mesh.matrix.set(p[0], p[4], p[8], 0, p[1], p[5], p[9], 0, p[2], p[6], p[10], 0, p[3], p[7], p[11], 1);
}

/** Triangles of polygons, each with its flat normal. */
function geometryOf(gl, polygons) {
    const [position, normal, kind] = [[], [], []];
    for (const polygon of polygons) {
        const n = normalOf(polygon.corners);
        for (let k = 1; k + 1 < polygon.corners.length; k++) {
            for (const corner of [polygon.corners[0], polygon.corners[k], polygon.corners[k + 1]]) {
                position.push(...corner);
                normal.push(...n);
                kind.push(polygon.kind);
            }
        }
    }
    return new Geometry(gl, {
        position: { size: 3, data: new Float32Array(position) },
        normal: { size: 3, data: new Float32Array(normal) },
        kind: { size: 1, data: new Float32Array(kind) },
    });
}

/** Numbers on both faces of facets: one texture, a quad on each face; `upright` : where a line of text runs to. */
function textOf(gl, solids, labels, motion, upright) {
    const cell = 64;
    const columns = Math.ceil(Math.sqrt(solids.length));
    const side = 2 ** Math.ceil(Math.log2(cell * columns));
    const canvas = document.createElement('canvas');
    canvas.width = canvas.height = side;
    const context = canvas.getContext('2d');
    labels.forEach((label, f) => {
        const size = label.length > 3 ? 22 : label.length > 2 ? 30 : 38;
        writeNumber(context, label, cell * ((f % columns) + 0.5), cell * (Math.floor(f / columns) + 0.5), size);
    });
    const map = new Texture(gl, { image: canvas, generateMipmaps: true, minFilter: gl.LINEAR_MIPMAP_LINEAR });
    const program = new Program(gl, {
        vertex: TEXT_VERTEX,
        fragment: TEXT_FRAGMENT,
        uniforms: { map: { value: map }, ink: { value: [0, 0, 0] } },
        transparent: true,
        depthWrite: false,
    });
    program.setBlendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const thickness = motion.payload.unit * motion.payload.thickness;
    const [cos, sin] = [Math.cos(upright), Math.sin(upright)];
    const meshes = solids.map((solid, f) => {
        const half = 0.62 * solid.reach;
        const [x, y] = solid.middle;
        const [u, v] = [(cell * (f % columns)) / side, 1 - (cell * Math.floor(f / columns)) / side];
        const [toU, toV] = [u + cell / side, v - cell / side];
        const [position, uv, index] = [[], [], []];
        for (const [z, flip] of [
            [thickness + 0.004 * half, 1],
            [-0.004 * half, -1],
        ]) {
            const first = position.length / 3;
            const corners = [
                [-1, -1],
                [1, -1],
                [1, 1],
                [-1, 1],
            ];
            for (const [a, b] of corners) {
                const [along, above] = [flip * a * half, b * half];
                position.push(x + along * cos - above * sin, y + along * sin + above * cos, z);
                uv.push(a < 0 ? u : toU, b < 0 ? toV : v);
            }
            index.push(...[0, 1, 2, 0, 2, 3].map((k) => first + k));
        }
        const geometry = new Geometry(gl, {
            position: { size: 3, data: new Float32Array(position) },
            uv: { size: 2, data: new Float32Array(uv) },
            index: { data: new Uint16Array(index) },
        });
        const mesh = new Mesh(gl, { geometry, program, frustumCulled: false, renderOrder: 1 });
        mesh.matrixAutoUpdate = false;
        return mesh;
    });
    return { meshes, program, map };
}
