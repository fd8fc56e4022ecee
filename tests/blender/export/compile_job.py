"""Compile a Flamenco job as its manager does, in a process of its own: `compile_job.py SCRIPT SETTINGS`, prints JSON.

The engine is V8; `author`, `job`, `print` and `path` are what Flamenco's documentation and its built-in job types use.
"""

import sys
from pathlib import Path

from py_mini_racer import mini_racer

MANAGER = """
const author = {
    Task: (name, type) => ({ name, type, commands: [], addCommand(command) { this.commands.push(command); } }),
    Command: (name, parameters) => ({ name, parameters }),
};
const print = () => {};
const tasks = [];
"""

script, settings = sys.argv[1:]
with mini_racer() as engine:  # closed before Python ends, else its thread is waited for without an end
    engine.eval(MANAGER)
    engine.eval(Path(script).read_text())
    engine.eval(f"compileJob({{ settings: {settings}, addTask: (task) => tasks.push(task) }})")
    print(engine.eval("JSON.stringify({ type: JOB_TYPE, tasks })"))
