// Reads an atlas in KTX2 by ktx-parse and writes the bytes of every level, and what else the file says:
//
//     node read_atlas_ktx2.mjs FOLDER FILE.ktx2 OUTPUT
//
// with ktx-parse installed in FOLDER/node_modules makes OUTPUT/level0.raw .. level6.raw and OUTPUT/ktx2.json, which
// check_ktx2.py compares with what ktx2.py reads.
import { createRequire } from 'node:module';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [folder, file, output] = process.argv.slice(2);
if (!output) {
  console.error('read_atlas_ktx2.mjs FOLDER FILE.ktx2 OUTPUT');
  process.exit(2);
}
const parser = createRequire(join(folder, 'index.js')).resolve('ktx-parse');
const { read } = await import(pathToFileURL(parser));

const container = read(readFileSync(file));
container.levels.forEach(({ levelData }, k) => writeFileSync(join(output, `level${k}.raw`), levelData));
const keyValues = Object.entries(container.keyValue).map(([key, value]) => [
  key,
  typeof value === 'string' ? value : Buffer.from(value).toString('utf8').replace(/\0$/, ''),
]);
const descriptor = container.dataFormatDescriptor[0];
writeFileSync(
  join(output, 'ktx2.json'),
  JSON.stringify({
    format: container.vkFormat,
    size: [container.pixelWidth, container.pixelHeight],
    levels: container.levels.length,
    compression: container.supercompressionScheme,
    transfer: descriptor.transferFunction,
    bits: descriptor.samples.map((sample) => sample.bitLength + 1),
    keyValues: Object.fromEntries(keyValues),
  }),
);
