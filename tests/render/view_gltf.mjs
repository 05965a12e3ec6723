// Shows a .glb in three.js in headless Chromium, as a web viewer frames it, and says how it stands there:
//   node view_gltf.mjs MODEL.glb [PICTURE.png]
// Prints {"tilt_deg", "shown", "at_rim", "triangles"}: the angle between +y and the mean of the upward facing surface that
// lies within 20 degrees of it; the share of the picture that the model takes; pixels of it on the picture's rim. Exit
// status 0, 1 when it could not be shown, 77 without three (npm install three) or chromium.
import { spawn, spawnSync } from 'node:child_process';
import { createServer } from 'node:http';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, normalize } from 'node:path';

const [model, picture] = process.argv.slice(2);
const three = join(process.cwd(), 'node_modules', 'three');
const browser = ['chromium', 'chromium-browser', 'google-chrome'].find(
    (name) => spawnSync(name, ['--version']).status === 0);
if (!existsSync(three) || !browser) {
  console.log(browser ? 'three is not installed (npm install three)' : 'chromium is not installed');
  process.exit(77);
}

const page = `<!doctype html><canvas id="canvas" width="960" height="640"></canvas>
<script type="importmap">{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
const say = (path, body) => fetch(path, { method: 'POST', body });
try {
  const { scene: model } = await new GLTFLoader().loadAsync('/model.glb');
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xff00ff);
  scene.add(model);
  scene.updateMatrixWorld(true);
  const sphere = new THREE.Box3().setFromObject(model).getBoundingSphere(new THREE.Sphere());
  const camera = new THREE.PerspectiveCamera(45, 960 / 640, sphere.radius / 100, sphere.radius * 100);
  camera.position.copy(sphere.center).add(
      new THREE.Vector3(0.5, 0.6, 1).normalize().multiplyScalar(sphere.radius / Math.sin(Math.PI / 8)));
  camera.lookAt(sphere.center);
  const canvas = document.getElementById('canvas');
  const renderer = new THREE.WebGLRenderer({ canvas, preserveDrawingBuffer: true });
  renderer.render(scene, camera);
  const pixels = new Uint8Array(960 * 640 * 4), gl = renderer.getContext();
  gl.readPixels(0, 0, 960, 640, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let shown = 0, at_rim = 0;
  for (let y = 0; y < 640; ++y)
    for (let x = 0; x < 960; ++x) {
      const i = 4 * (y * 960 + x);
      if (pixels[i] === 255 && pixels[i + 1] === 0 && pixels[i + 2] === 255) continue;
      ++shown;
      if (x === 0 || y === 0 || x === 959 || y === 639) ++at_rim;
    }
  const up = new THREE.Vector3(), sum = new THREE.Vector3(), p = [0, 1, 2].map(() => new THREE.Vector3());
  let triangles = 0;
  model.traverse((mesh) => {
    if (!mesh.isMesh) return;
    const place = mesh.geometry.attributes.position, index = mesh.geometry.index;
    for (let i = 0; i + 2 < index.count; i += 3) {
      p.forEach((v, k) => v.fromBufferAttribute(place, index.getX(i + k)).applyMatrix4(mesh.matrixWorld));
      up.crossVectors(p[1].sub(p[0]), p[2].sub(p[0]));
      ++triangles;
      if (up.y > Math.cos(20 * Math.PI / 180) * up.length()) sum.add(up);
    }
  });
  const tilt_deg = sum.length() > 0 ? Math.acos(sum.y / sum.length()) * 180 / Math.PI : 180;
  await say('/picture', canvas.toDataURL('image/png'));
  await say('/says', JSON.stringify({ tilt_deg, shown: shown / (960 * 640), at_rim, triangles }));
} catch (error) {
  await say('/failed', String(error));
}
</script>`;

const profile = mkdtempSync(join(tmpdir(), 'view_gltf-'));
let child;
const end = (status, words) => {
  console.log(words);
  child?.kill('SIGKILL');
  server.close();
  setTimeout(() => {
    rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
    process.exit(status);
  }, 200);
};
const hear = (url, body) => {
  if (url === '/picture' && picture) writeFileSync(picture, Buffer.from(body.split(',')[1], 'base64'));
  if (url === '/says') end(0, body);
  if (url === '/failed') end(1, body);
};
const server = createServer((request, response) => {
  if (request.method === 'POST') {
    let body = '';
    request.on('data', (part) => (body += part));
    request.on('end', () => (response.end(), hear(request.url, body)));
  } else if (request.url === '/') {
    response.setHeader('Content-Type', 'text/html').end(page);
  } else if (request.url === '/model.glb') {
    response.end(readFileSync(model));
  } else if (request.url.startsWith('/three/') && existsSync(join(three, normalize(request.url.slice(6))))) {
    response.setHeader('Content-Type', 'text/javascript').end(readFileSync(join(three, normalize(request.url.slice(6)))));
  } else {
    response.writeHead(404).end();
  }
});
server.listen(0, '127.0.0.1', () => {
  child = spawn(browser, ['--headless', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--no-first-run', `--user-data-dir=${profile}`, `http://127.0.0.1:${server.address().port}/`], { stdio: 'ignore' });
  child.on('error', (error) => end(1, String(error)));
});
setTimeout(() => end(1, 'the browser did not answer within two minutes'), 120000);
