"""A plug-in of Krita that does the jobs in jobs.json, writes what became of them, and quits."""

import json
import os
import time
import traceback
from pathlib import Path

from krita import Krita, Selection
from PyQt5.QtCore import QRect, QTimer
from PyQt5.QtWidgets import QApplication
from weftex_krita import command, tasks
from weftex_krita.extension import Job

FOLDER = Path(os.environ["WEFTEX_TEST_FOLDER"])


def described(document, name):
    """Write the pixels of all layers to files, and return what else there is to know."""
    found = []
    for node in document.rootNode().childNodes():
        if node.type() != "paintlayer":
            continue
        area = node.bounds().intersected(QRect(0, 0, document.width(), document.height()))
        box = [area.x(), area.y(), area.width(), area.height()]
        file = f"{name}-{len(found)}.raw"
        (FOLDER / file).write_bytes(bytes(node.pixelData(*box)) if not area.isEmpty() else b"")
        space = [node.colorModel(), node.colorDepth(), node.colorProfile()]
        found.append({"name": node.name(), "box": box, "space": space, "file": file})
    return {"size": [document.width(), document.height()], "layers": found}


def spin(until, seconds=120):
    end = time.monotonic() + seconds
    while not until() and time.monotonic() < end:
        QApplication.processEvents()
        time.sleep(0.01)
    return until()


def do(number, job):
    krita = Krita.instance()
    model, depth = job["space"]
    document = krita.createDocument(*job["size"], "test", model, depth, job.get("profile", ""), 72)
    krita.activeWindow().addView(document)
    krita.setActiveDocument(document)
    document.waitForDone()
    for old in document.rootNode().childNodes()[1:]:
        old.remove()
    node = document.rootNode().childNodes()[0]
    x, y, width, height = job["box"]
    node.setPixelData(bytes(document.width() * document.height() * 16), 0, 0, *job["size"])
    node = document.createNode("photo", "paintlayer")
    if "layer space" in job:
        node.setColorSpace(*job["layer space"], "sRGB-elle-V2-g10.icc")
    node.setPixelData((FOLDER / job["file"]).read_bytes(), x, y, width, height)
    document.rootNode().addChildNode(node, None)
    for one in document.rootNode().childNodes():
        if one.name() != "photo":
            one.remove()
    document.setActiveNode(node)
    if "select" in job:
        selection = Selection()
        for *box, value in job["select"]:
            part = Selection()
            part.select(*box, value)
            selection.add(part)
        document.setSelection(selection)
    document.refreshProjection()
    document.waitForDone()
    done, errors = {"before": described(document, f"{number}-before")}, []
    kind = {one.title: one for one in tasks.TASKS}[job["task"]]
    try:
        path = command.find_command()
        run = Job(kind, document, node if job.get("node", True) else None, job["values"], path)
        folder = run._folder.path
        run.start(errors.append)
        ticks = []
        timer = QTimer()
        timer.timeout.connect(lambda: ticks.append(0))
        timer.start(20)
        if job.get("cancel"):
            spin(lambda: run._run.stage not in ("starting", "preparing"))
            run.cancel()
        done["over"] = spin(lambda: run.over)
        timer.stop()
        done["events meanwhile"] = len(ticks)
        done["left"] = folder.exists()
        done["error"] = run.error or "".join(errors)
        if run.made is not None and job["task"] == "Make More":
            done["made"] = described(run.made, f"{number}-made")
            run.made.setModified(False)
            run.made.close()
    except command.Problem as problem:
        done["error"] = str(problem)
    document.waitForDone()
    done["after"] = described(document, f"{number}-after")
    if job.get("undo"):
        krita.setActiveDocument(document)
        krita.action("edit_undo").trigger()
        spin(lambda: document.nodeByName(run.made.name()) is None, 5)
        document.waitForDone()
        done["undone"] = described(document, f"{number}-undone")
    document.setModified(False)
    document.close()
    return done


def do_all():
    """Do the jobs and end Krita, which asks nothing as this process just ends."""
    try:
        jobs = json.loads((FOLDER / "jobs.json").read_text("utf-8"))
        done = [do(number, job) for number, job in enumerate(jobs)]
        (FOLDER / "done.json").write_text(json.dumps(done), "utf-8")
    except BaseException:
        (FOLDER / "failed.txt").write_text(traceback.format_exc(), "utf-8")
    os._exit(0)


def begin():
    """Start once there is a window."""
    if Krita.instance().activeWindow() is None:
        QTimer.singleShot(500, begin)
    else:
        QTimer.singleShot(1000, do_all)


QTimer.singleShot(500, begin)
