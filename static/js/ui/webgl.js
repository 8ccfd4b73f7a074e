// Detect whether this browser can draw the 3-D map.

/** @returns {boolean} */
export function canDraw() {
  try {
    const context = document.createElement("canvas").getContext("webgl2");
    context?.getExtension("WEBGL_lose_context")?.loseContext(); // browsers keep few of them
    return context !== null;
  } catch {
    return false;
  }
}

export const MAP_DRAWN = canDraw();
