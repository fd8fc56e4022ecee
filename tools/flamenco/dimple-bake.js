// SPDX-License-Identifier: GPL-3.0-or-later
// A job type of Flamenco, Blender's render manager: bake Dimple bodies and export them, a task for each object, or for
// each group of objects that meet.
// Copy it into the folder `scripts` beside flamenco-manager; every worker needs Blender with Dimple installed.

const JOB_TYPE = {
    label: "Dimple Bake",
    description: "Export the animation of the Dimple bodies of a scene: their bakes, and the others simulated",
    settings: [
        { key: "objects", type: "string", required: true,
          // where anything is ticked under Contact, all of them meet
          eval: "(lambda bodies, meet: __import__('json').dumps([bodies] if meet and bodies else bodies))("
              + "[o.name for o in C.scene.objects if o.type == 'MESH' and o.dimple.enabled], "
              + "any(o.dimple.collider or o.dimple.enabled and o.dimple.self_contact for o in C.scene.objects))",
          evalInfo: { showLinkButton: true, description: "Every Dimple body of the scene" },
          description: "The objects, as a JSON list of their names. Each is a task of its own; those that meet are one "
                     + "task, in a list of their own: [[\"Hand\", \"Ball\"], \"Cushion\"]" },
        { key: "frames", type: "string", required: true,
          eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
          evalInfo: { showLinkButton: true, description: "Scene frame range" },
          description: "First and last frame, for example '1-250'" },
        { key: "formats", type: "string", required: true, default: "abc",
          description: "abc, usd, glb, fbx, pc2 or vat, separated by commas" },
        { key: "output", type: "string", subtype: "dir_path", required: true,
          description: "The folder of the files, the same on every worker" },
        { key: "overwrite", type: "bool", default: false, visible: "submission",
          description: "Replace files that are there already" },
        { key: "blendfile", type: "string", required: true, visible: "web", description: "The .blend file" },
    ]
};

function compileJob(job) {
    for (const names of objectNames(job.settings.objects)) {
        job.addTask(bakeTask(job.settings, names));
    }
}

function bakeTask(settings, names) {
    const task = author.Task(`bake-${names.join("-")}`, "blender");
    task.addCommand(author.Command("blender-render", {
        exe: "{blender}",
        exeArgs: "{blenderArgs}",
        // the worker calls: exe exeArgs argsBefore blendfile args
        argsBefore: ["--command", "dimple", "bake"],
        blendfile: settings.blendfile,
        args: [
            // with "=", so that no name is taken for an option
            ...names.map((name) => `--object=${name}`),
            `--frames=${settings.frames}`,
            `--format=${settings.formats}`,
            `--out=${settings.output}`,
        ].concat(settings.overwrite ? ["--overwrite"] : []),
    }));
    return task;
}

// Return lists of names: the objects of each task.
function objectNames(text) {
    const given = JSON.parse(text);
    const groups = Array.isArray(given) ? given.map((each) => Array.isArray(each) ? each : [each]) : [];
    const names = groups.flat();
    if (names.length === 0 || groups.some((each) => each.length === 0) || names.some((name) => typeof name !== "string")) {
        throw "There is no Dimple body: switch Physics > Dimple on for the objects to bake.";
    }
    return groups;
}
