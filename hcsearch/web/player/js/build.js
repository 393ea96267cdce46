// Bundles src/player.js with OGL into one script, ../player.js or the file named as the first argument.
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { buildSync } from 'esbuild';

const licence = readFileSync(new URL('LICENSE-ogl.txt', import.meta.url), 'utf8').trim();
buildSync({
    absWorkingDir: fileURLToPath(new URL('.', import.meta.url)),
    entryPoints: ['src/player.js'],
    outfile: process.argv[2] ?? '../player.js',
    bundle: true,
    minify: true,
    format: 'iife',
    target: 'es2020',
    charset: 'ascii',
    legalComments: 'none',
    logLevel: 'warning',
    banner: { js: `/*! The player of hcsearch (MIT), bundled with OGL 1.0.11:\n\n${licence}\n*/` },
});
