// What this browser's WebGL is good for, asked once with a context that is given back at once.

// names of drivers that draw on the processor: SwiftShader, Mesa's llvmpipe and softpipe, Windows' WARP
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

let known = null;

/** 'none', 'software' (the processor draws, and the page waits for it) or 'chip'. */
export function webgl() {
  known ??= ask();
  return known;
}

function ask() {
  try {
    const gl = document.createElement('canvas').getContext('webgl2');
    if (!gl) return 'none';
    const info = gl.getExtension('WEBGL_debug_renderer_info');
    const kind = kindOf(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    gl.getExtension('WEBGL_lose_context')?.loseContext();
    return kind;
  } catch {
    return 'none';
  }
}

/** The kind of a renderer by its name; a name that tells nothing is taken for a chip. */
export function kindOf(renderer) {
  return SOFTWARE.test(String(renderer ?? '')) ? 'software' : 'chip';
}
