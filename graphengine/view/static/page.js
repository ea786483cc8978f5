// The page of a run. The 3D part is a separate frame.
import { connect } from "./connection.js";
import { $ } from "./elements.js";
import "./control.js";
import "./tree.js";
import "./robot.js";
import "./graphs.js";
import "./node.js";
import "./topics.js";
import "./findings.js";
import "./keyboard.js";
import "./recording.js";

$("world").src = matchMedia("(prefers-color-scheme: dark)").matches ? "3d/?darkMode" : "3d/";
connect();
