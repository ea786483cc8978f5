// The page of a run. The world in 3D is a frame of its own.
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
