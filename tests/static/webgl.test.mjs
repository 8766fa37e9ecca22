// Which drivers draw on the processor.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kindOf } from '../../static/js/map/webgl.js';

test('drivers that draw on the processor are told from graphics chips', () => {
  for (const name of [
    'ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero) (0x0000C0DE)), SwiftShader driver)',
    'llvmpipe (LLVM 15.0.7, 256 bits)',
    'ANGLE (Microsoft, Microsoft Basic Render Driver (0x0000008C) Direct3D11 vs_5_0 ps_5_0)',
    'Apple Software Renderer',
  ]) assert.equal(kindOf(name), 'software', name);
  for (const name of ['ANGLE (Qualcomm, Adreno (TM) 660)', 'Mali-G78', 'Apple GPU', 'ANGLE (Intel, Mesa Intel(R) UHD Graphics 620)', '', null])
    assert.equal(kindOf(name), 'chip', String(name));
});
