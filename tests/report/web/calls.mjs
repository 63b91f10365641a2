// Calls functions of the page's modules: [[module, function, arguments], ...] as JSON comes in, the results go out.
import {readFileSync} from 'node:fs';

const calls = JSON.parse(readFileSync(0, 'utf8'));
const results = [];
for (const [module, name, given] of calls) results.push((await import(`#web/${module}.mjs`))[name](...given) ?? null);
process.stdout.write(JSON.stringify(results));
