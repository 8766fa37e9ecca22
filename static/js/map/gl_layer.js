// Our own picture over MapLibre's: mission lines, trail, marks and machines, all instanced, a handful of draw calls.
// It has a canvas of its own: robots move all the time, and the farm below them need not be drawn again for that.
// The view is flat (no pitch), so the shaders use the camera of geometry.js and not MapLibre's matrices.

import { DEG, mercPerMetre } from './geometry.js';
import { LINE_FLOATS, STAMP_WORDS } from './drawlist.js';
import { buildMeshes, VERTEX_FLOATS } from './meshes.js';

const VIEW = `
uniform vec2 u_centre; uniform vec2 u_turn; uniform vec2 u_view; uniform float u_world; uniform float u_perM;
vec2 toPx(vec2 rel) { vec2 d = (rel - u_centre) * u_world;
  return vec2(d.x * u_turn.x + d.y * u_turn.y, -d.x * u_turn.y + d.y * u_turn.x); }
vec4 toClip(vec2 px) { return vec4(px.x / u_view.x * 2.0, -px.y / u_view.y * 2.0, 0.0, 1.0); }`;

const LINE_VERTEX = `#version 300 es
precision highp float;
in vec2 a_corner; in vec4 a_ends; in float a_walked;
uniform float u_width; uniform float u_cap; uniform float u_px; uniform vec2 u_dash;
out float v_off; out float v_along; out float v_half;
${VIEW}
void main() {
  vec2 p = toPx(a_ends.xy); vec2 q = toPx(a_ends.zw);
  vec2 d = q - p; float len = length(d); vec2 dir = len > 0.0 ? d / len : vec2(1.0, 0.0);
  v_half = u_width * 0.5;
  v_off = a_corner.y * (v_half + u_px);
  float along = a_corner.x * len + (a_corner.x * 2.0 - 1.0) * u_cap;
  // the pattern starts again at each piece: interpolating a long way loses dashes
  float period = max(u_dash.x + u_dash.y, 1.0);
  v_along = mod(a_walked * u_perM, period) + along;
  gl_Position = toClip(p + dir * along + vec2(-dir.y, dir.x) * v_off);
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in float v_off; in float v_along; in float v_half;
uniform vec4 u_colour; uniform vec2 u_dash; uniform float u_px;
out vec4 colour;
void main() {
  float alpha = clamp((v_half - abs(v_off)) / u_px + 0.5, 0.0, 1.0) * u_colour.a;
  if (u_dash.x > 0.0) {
    float at = mod(v_along, u_dash.x + u_dash.y);
    alpha *= clamp(min(at, u_dash.x - at) / u_px + 0.5, 0.0, 1.0);
  }
  colour = vec4(u_colour.rgb * alpha, alpha);
}`;

const STAMP_VERTEX = `#version 300 es
precision highp float;
in vec2 a_unit; in vec2 a_offset; in vec2 a_paint;
in vec2 a_place; in vec2 a_heading; in vec4 a_size; in vec4 a_fill; in vec4 a_accent; in vec4 a_rim;
uniform float u_px;
out vec4 v_colour;
${VIEW}
void main() {
  float scale = max(u_perM, a_size.z * u_px / max(a_size.y, 0.01));
  vec2 body = (a_unit + vec2(0.0, a_size.w)) * a_size.xy * 0.5 * scale + a_offset * u_px;
  float c = a_heading.x * u_turn.x + a_heading.y * u_turn.y;
  float s = a_heading.y * u_turn.x - a_heading.x * u_turn.y;
  vec2 turned = vec2(body.x * c + body.y * s, body.x * s - body.y * c);
  vec4 paint = a_paint.x < 0.5 ? a_fill : (a_paint.x < 1.5 ? a_accent : a_rim);
  float alpha = paint.a * a_paint.y;
  v_colour = vec4(paint.rgb * alpha, alpha);
  gl_Position = toClip(toPx(a_place) + turned);
}`;

const STAMP_FRAGMENT = `#version 300 es
precision mediump float;
in vec4 v_colour; out vec4 colour;
void main() { colour = v_colour; }`;

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(made));
  const names = (kind, count, get) => Object.fromEntries(Array.from({ length: count }, (_, i) => {
    const { name } = kind === 'uniform' ? gl.getActiveUniform(made, i) : gl.getActiveAttrib(made, i);
    return [name, get(name)];
  }));
  return {
    made,
    uniforms: names('uniform', gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS), (n) => gl.getUniformLocation(made, n)),
    places: names('attrib', gl.getProgramParameter(made, gl.ACTIVE_ATTRIBUTES), (n) => gl.getAttribLocation(made, n)),
  };
}

const CONTEXT = { alpha: true, premultipliedAlpha: true, antialias: false, depth: false, stencil: false };

/** Draws `scene.drawList()` on a canvas of its own in `host`; `camera` is kept equal to MapLibre's by the engine. */
export class SceneLayer {
  /** heard: {lost(), restored()} of its graphics context. */
  constructor(scene, camera, host, heard) {
    this.scene = scene;
    this.camera = camera;
    this.host = host;
    this.heard = heard;
  }

  /** Where nothing was ever drawn there is no canvas: an editor has none. */
  #open() {
    const canvas = document.createElement('canvas');
    canvas.className = 'hl-map-scene';
    canvas.setAttribute('aria-hidden', 'true');
    const gl = canvas.getContext('webgl2', CONTEXT);
    this.canvas = canvas;
    if (!gl) { // a device may give one context and not two
      this.isLost = true;
      return void this.heard.lost();
    }
    canvas.addEventListener('webglcontextlost', (event) => this.#lost(event));
    canvas.addEventListener('webglcontextrestored', () => { this.isLost = false; this.#build(gl); this.heard.restored(); });
    this.host.append(canvas);
    this.#build(gl);
    return undefined;
  }

  #lost(event) {
    if (this.isGone) return;
    event.preventDefault(); // or it never comes back
    this.isLost = true;
    this.heard.lost();
  }

  #build(gl) {
    this.gl = gl;
    this.lines = program(gl, LINE_VERTEX, LINE_FRAGMENT);
    this.stamps = program(gl, STAMP_VERTEX, STAMP_FRAGMENT);
    this.corner = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corner);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, -1, 1, -1, 0, 1, 1, 1]), gl.STATIC_DRAW);
    this.lineBuffers = new Map();
    this.meshes = {};
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    for (const [name, mesh] of Object.entries(buildMeshes())) this.meshes[name] = this.#mesh(gl, mesh);
  }

  #mesh(gl, { vertices, indices }) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const { places } = this.stamps;
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
    [['a_unit', 0], ['a_offset', 8], ['a_paint', 16]].forEach(([name, at]) => {
      gl.enableVertexAttribArray(places[name]);
      gl.vertexAttribPointer(places[name], 2, gl.FLOAT, false, VERTEX_FLOATS * 4, at);
    });
    const records = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, records);
    const per = (name, size, type, norm, at) => {
      gl.enableVertexAttribArray(places[name]);
      gl.vertexAttribPointer(places[name], size, type, norm, STAMP_WORDS * 4, at);
      gl.vertexAttribDivisor(places[name], 1);
    };
    per('a_place', 2, gl.FLOAT, false, 0);
    per('a_heading', 2, gl.FLOAT, false, 8);
    per('a_size', 4, gl.FLOAT, false, 16);
    per('a_fill', 4, gl.UNSIGNED_BYTE, true, 32);
    per('a_accent', 4, gl.UNSIGNED_BYTE, true, 36);
    per('a_rim', 4, gl.UNSIGNED_BYTE, true, 40);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { array, records, count: indices.length };
  }

  /** Draw everything as large as `width` x `height` device px. */
  draw(width, height) {
    const { lines, stamps } = this.scene.drawList();
    if (!this.canvas && !lines.length && !stamps.length) return;
    if (!this.canvas) this.#open();
    if (this.isLost) return;
    const { gl, canvas } = this;
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const ratio = gl.drawingBufferWidth / this.camera.width;
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.useProgram(this.lines.made);
    this.#view(gl, this.lines.uniforms, ratio);
    for (const line of lines) this.#line(gl, line, ratio);
    gl.useProgram(this.stamps.made);
    this.#view(gl, this.stamps.uniforms, ratio);
    for (const batch of stamps) this.#stamp(gl, batch);
    gl.bindVertexArray(null);
  }

  #view(gl, uniforms, ratio) {
    const { camera, scene } = this;
    const world = camera.worldPx * ratio;
    gl.uniform2f(uniforms.u_centre, camera.mx - scene.origin.mx, camera.my - scene.origin.my);
    gl.uniform2f(uniforms.u_turn, Math.cos(camera.bearing * DEG), Math.sin(camera.bearing * DEG));
    gl.uniform2f(uniforms.u_view, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.uniform1f(uniforms.u_world, world);
    gl.uniform1f(uniforms.u_perM, world * mercPerMetre(camera.my));
    gl.uniform1f(uniforms.u_px, ratio);
  }

  #lineArray(gl, set) {
    let held = this.lineBuffers.get(set);
    if (!held) {
      held = { buffer: gl.createBuffer(), array: gl.createVertexArray() };
      this.lineBuffers.set(set, held);
      set.dirty = true;
    }
    if (set.dirty) {
      gl.bindBuffer(gl.ARRAY_BUFFER, held.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, set.data.subarray(0, set.count * LINE_FLOATS), gl.DYNAMIC_DRAW);
      set.dirty = false;
    }
    return held;
  }

  #line(gl, { set, from, count, colour, widthM = 0, leastPx = 1, dash = null, cap = 0.5 }, ratio) {
    if (!count) return;
    const held = this.#lineArray(gl, set);
    const { uniforms, places } = this.lines;
    gl.bindVertexArray(held.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corner);
    gl.enableVertexAttribArray(places.a_corner);
    gl.vertexAttribPointer(places.a_corner, 2, gl.FLOAT, false, 8, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, held.buffer);
    const start = from * LINE_FLOATS * 4; // WebGL 2 has no base instance
    for (const [name, size, at] of [['a_ends', 4, 0], ['a_walked', 1, 16]]) {
      gl.enableVertexAttribArray(places[name]);
      gl.vertexAttribPointer(places[name], size, gl.FLOAT, false, LINE_FLOATS * 4, start + at);
      gl.vertexAttribDivisor(places[name], 1);
    }
    const width = Math.max(widthM / this.camera.metresPerPx, leastPx) * ratio;
    gl.uniform1f(uniforms.u_width, width);
    gl.uniform1f(uniforms.u_cap, dash ? 0 : cap * ratio);
    gl.uniform2f(uniforms.u_dash, dash ? dash[0] * ratio : 0, dash ? dash[1] * ratio : 0);
    gl.uniform4f(uniforms.u_colour, (colour & 255) / 255, ((colour >> 8) & 255) / 255, ((colour >> 16) & 255) / 255, (colour >>> 24) / 255);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
  }

  #stamp(gl, batch) {
    const mesh = this.meshes[batch.shape];
    gl.bindVertexArray(mesh.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.records);
    gl.bufferData(gl.ARRAY_BUFFER, batch.floats.subarray(0, batch.count * STAMP_WORDS), gl.DYNAMIC_DRAW);
    gl.drawElementsInstanced(gl.TRIANGLES, mesh.count, gl.UNSIGNED_SHORT, 0, batch.count);
  }

  destroy() {
    this.isGone = true;
    this.lineBuffers?.clear();
    this.gl?.getExtension('WEBGL_lose_context')?.loseContext(); // browsers keep few of them
    this.canvas?.remove();
  }
}
