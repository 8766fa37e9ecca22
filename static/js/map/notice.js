// The sentence over the map when it cannot show what it should: never a blank map without a word.

/** [text, {canRetry, isSmall}] for the controls; the text is empty when all is well. */
export function noticeOf(intake, { isReady, engineNote }) {
  const { robotId, mode } = intake.options;
  const name = intake.selected?.name ?? robotId;
  if (!isReady) return ['Loading map', {}];
  if (intake.farmState === 'forbidden') return ['This map is not shared with you.', {}];
  if (intake.farmState === 'failed') return ['Map did not load. It is asked for again.', { canRetry: true }];
  if (intake.missionState === 'failed') return ['Mission lines did not load. They are asked for again.', { canRetry: true, isSmall: true }];
  if (intake.farmState === 'loading' && !intake.farm.features.length) return ['Loading map', {}];
  if (mode === 'robot' && !robotId) return ['No robot chosen.', {}];
  if (mode === 'robot' && !intake.placed) return [`No position from ${name} yet.`, {}];
  if (!intake.farm.features.length && !intake.placed && mode !== 'stations') return ['No fields and no robots on the map yet.', {}];
  return [engineNote, { isSmall: true }];
}
