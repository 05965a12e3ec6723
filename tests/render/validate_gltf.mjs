// Validates .glb files with Khronos' validator (npm install gltf-validator): node validate_gltf.mjs FILE...
// Prints one line a file and every message; exit status 0 without errors and warnings, 1 with, 77 without the validator.
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';

let validator;
try {
  validator = createRequire(process.cwd() + '/')('gltf-validator');
} catch {
  console.log('gltf-validator is not installed (npm install gltf-validator)');
  process.exit(77);
}
let bad = 0;
for (const file of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)), { uri: file, maxIssues: 20 });
  console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos`);
  for (const m of issues.messages) console.log(`  ${m.code} ${m.pointer ?? ''} ${m.message}`);
  bad += issues.numErrors + issues.numWarnings;
}
process.exit(bad === 0 ? 0 : 1);
