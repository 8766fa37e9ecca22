// Which engine draws the map: the full one where the device can, else a simple one; each loads only when it is used.

/** Start an engine. Returns {engine, note}: the note says why it is the simple one, when nobody asked for it. */
export async function startEngine(wanted, surface, setup) {
  if (wanted === 'canvas') return { engine: await canvas(surface, setup), note: '' };
  try {
    const { GlEngine, hasWebGl } = await import('./gl_engine.js');
    if (hasWebGl()) return { engine: await GlEngine.create(surface, setup), note: '' };
    return { engine: await canvas(surface, setup), note: 'Simple map: this device has no WebGL.' };
  } catch (error) {
    console.warn('map: the GL engine did not start:', error);
    return { engine: await canvas(surface, setup), note: 'Simple map: the full one did not load.' };
  }
}

async function canvas(surface, setup) {
  surface.replaceChildren();
  const { CanvasEngine } = await import('./canvas_engine.js');
  return CanvasEngine.create(surface, setup);
}
