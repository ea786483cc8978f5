// The token of the run, without which the run sends no data. It comes with the fragment of the printed address, which browsers send to
// no server, and is kept for reloads of this tab. Cookies would reach all ports of the host.
const given = new URLSearchParams(location.hash.slice(1)).get("token");
if (given !== null) {
  sessionStorage.setItem("token", given);
  history.replaceState(null, "", location.pathname);
}
addEventListener("hashchange", () => location.reload()); // the address of another run was opened in this tab

// Returns the address of a WebSocket of the run; null without a token.
function socketUrl(path) {
  const token = sessionStorage.getItem("token");
  return token && `${location.origin.replace("http", "ws")}/${path}?token=${encodeURIComponent(token)}`;
}
