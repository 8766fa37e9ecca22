// A WHEP viewer on a WebRTC stack that is not ours. Speaks lines of JSON: says its offer, hears the answer, then says
// what came: packets, the codec, key pictures (an H.264 sequence header), RTP times, and pictures counted by marker bits.

import { createInterface } from "node:readline";
import { RTCPeerConnection, RTCRtpCodecParameters } from "werift";

const CODECS = {
  H264: { mimeType: "video/H264", parameters: "level-asymmetry-allowed=1;packetization-mode=1;profile-level-id=42e01f" },
  VP8: { mimeType: "video/VP8" },
};
const say = (line) => process.stdout.write(`${JSON.stringify(line)}\n`);
const codec = new RTCRtpCodecParameters({
  ...CODECS[process.argv[2] ?? "H264"], clockRate: 90000,
  rtcpFeedback: [{ type: "nack" }, { type: "nack", parameter: "pli" }],
});
const peer = new RTCPeerConnection({ codecs: { audio: [], video: [codec] }, iceServers: [] });
const came = { packets: 0, pictures: 0, keys: 0, times: [], codec: codec.mimeType };

// 7 is a sequence header: alone, first in an aggregate (24), or at the start of a fragment (28)
function isKey(bytes) {
  const kind = bytes[0] & 31;
  if (kind === 24) return (bytes[3] & 31) === 7;
  if (kind === 28) return Boolean(bytes[1] & 128) && (bytes[1] & 31) === 7;
  return kind === 7;
}

const transceiver = peer.addTransceiver("video", { direction: "recvonly" });
transceiver.onTrack.subscribe((track) => {
  track.onReceiveRtp.subscribe((packet) => {
    came.packets += 1;
    if (codec.mimeType === "video/H264" && isKey(packet.payload)) came.keys += 1;
    if (!packet.header.marker) return;
    came.pictures += 1;
    came.times.push(packet.header.timestamp);
    say({ came });
  });
});
peer.connectionStateChange.subscribe((state) => say({ state }));
await peer.setLocalDescription(await peer.createOffer());
say({ offer: peer.localDescription.sdp });
for await (const line of createInterface({ input: process.stdin })) {
  const { answer } = JSON.parse(line);
  if (!answer) break;
  await peer.setRemoteDescription({ type: "answer", sdp: answer });
}
await peer.close();
process.exit(0);
