// Which engine draws the map: the full one where the device can, else a simple one; each loads only when it is used.
import { webgl } from './webgl.js';

/**
 * Start an engine. Returns {engine, note}: the note says why it is the simple one, when nobody asked for it.
 *
 * wanted: 'auto' takes WebGL where there is one; 'quick' only where a graphics chip draws it, for WebGL in software
 * keeps the page waiting a tenth of a second at a time; 'canvas' never does.
 */
export async function startEngine(wanted, surface, setup) {
  if (wanted === 'canvas') return { engine: await canvas(surface, setup), note: '' };
  if (webgl() === 'none') return { engine: await canvas(surface, setup), note: 'Simple map: this device has no WebGL.' };
  if (wanted === 'quick' && webgl() === 'software') return { engine: await canvas(surface, setup), note: '' };
  try {
    const { GlEngine } = await import('./gl_engine.js');
    return { engine: await GlEngine.create(surface, setup), note: '' };
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
