"""The menu Tools > Scripts > weftex, its dialogs and the progress of a run."""

from __future__ import annotations

from typing import Any

from krita import Extension, Krita
from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QLabel,
    QMenu,
    QMessageBox,
    QProgressDialog,
    QSpinBox,
)

from . import command
from .command import Canceled, Problem
from .tasks import TASKS


class WeftexExtension(Extension):  # type: ignore[misc]
    """Adds the menu to each window."""

    def setup(self) -> None:
        """Do nothing; Krita calls this once."""

    def createActions(self, window: Any) -> None:
        """Add the submenu with an action for each task."""
        parent = window.createAction("weftex", "weftex", "tools/scripts")
        parent.setMenu(QMenu("weftex", window.qwindow()))
        for kind in TASKS:
            name = "weftex_" + kind.title.lower().replace(" ", "_")
            action = window.createAction(name, f"{kind.title}...", "tools/scripts/weftex")
            action.triggered.connect(lambda _=False, kind=kind: ask(kind))


def ask(kind: Any) -> None:
    """Show the dialog of a task, and start it."""
    krita = Krita.instance()
    document, window = krita.activeDocument(), krita.activeWindow()
    dialog = TaskDialog(kind, window.qwindow())
    if document is None:
        warn(kind.title, "Open an image and select a layer")
    elif dialog.exec_() == QDialog.Accepted:
        try:
            path = locate(dialog)
            job = Job(kind, document, document.activeNode(), dialog.values(), path)
        except Canceled:
            return
        except command.FAILURES as failure:
            warn(kind.title, command.message_of(failure))
            return
        job.start(lambda message: warn(kind.title, message))


def warn(title: str, message: str) -> None:
    """Show why nothing was made."""
    QMessageBox.warning(Krita.instance().activeWindow().qwindow(), f"weftex: {title}", message)


def locate(parent: Any) -> str:
    """Return the path of the command; ask for it where it is not found, and keep the answer."""
    krita = Krita.instance()
    try:
        return command.find_command(krita.readSetting("weftex", "command", ""))
    except Problem as problem:
        box = QMessageBox(QMessageBox.Warning, "weftex", str(problem), parent=parent)
        named = box.addButton("Locate weftex...", QMessageBox.AcceptRole)
        box.addButton(QMessageBox.Cancel)
        box.exec_()
        if box.clickedButton() is not named:
            raise Canceled("Canceled") from None
    path, _ = QFileDialog.getOpenFileName(parent, "Locate the command weftex")
    if not path:
        raise Canceled("Canceled")
    command.check_version(path)
    krita.writeSetting("weftex", "command", path)
    return path


class Job:
    """A task whose command runs beside Krita; a timer looks after it, so nothing blocks.

    Attributes
    ----------
    made : object
        The new layer or document, once the command has finished well.
    error : str
        Why nothing was made; empty if it was canceled.
    over : bool
    """

    #: Jobs that run, which nobody else holds.
    running: list[Job] = []  # noqa: RUF012

    def __init__(self, kind: Any, document: Any, node: Any, values: dict[str, Any], path: str):
        command.check_version(path)
        self.made, self.error, self.over = None, "", False
        self._folder = command.Folder()
        try:
            self._task = kind(document, node, values, self._folder.__enter__())
            self._run = command.Run(path, self._task.words)
        except BaseException:
            self._folder.__exit__()
            raise

    def start(self, warn: Any) -> None:
        """Show the progress, and return at once; `warn` is called with an error."""
        window = Krita.instance().activeWindow()
        self._warn = warn
        self._bar = QProgressDialog("starting", "Cancel", 0, 1000, window and window.qwindow())
        self._bar.setWindowTitle(f"weftex: {self._task.title}")
        self._bar.setMinimumWidth(320)
        self._bar.setWindowModality(Qt.WindowModal)
        self._bar.setAutoReset(False)
        self._bar.setAutoClose(False)
        self._bar.setMinimumDuration(500)
        self._timer = QTimer()
        self._timer.timeout.connect(self._look)
        self._timer.start(100)
        Job.running.append(self)

    def cancel(self) -> None:
        """Cancel, as the button does."""
        self._bar.cancel()

    def _look(self) -> None:
        """Show the progress; finish when the command has ended."""
        if self._run.running:
            if self._bar.wasCanceled():
                self._run.cancel()
            else:
                self._bar.setLabelText(self._run.stage)
                self._bar.setValue(round(1000 * self._run.share))
            return
        self._timer.stop()
        self._bar.reset()
        self._bar.deleteLater()
        try:
            self._run.finish()
            self.made = self._task.finish()
        except Canceled:
            pass
        except command.FAILURES as failure:
            self.error = command.message_of(failure)
        finally:
            self._folder.__exit__()
            Job.running.remove(self)
            self.over = True
        if self.error:
            self._warn(self.error)


class TaskDialog(QDialog):  # type: ignore[misc]
    """Asks for the options of a task."""

    def __init__(self, kind: Any, parent: Any) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"weftex: {kind.title}")
        form, self._read = QFormLayout(self), {}
        about = QLabel(kind.about)
        about.setWordWrap(True)
        form.addRow(about)
        for option in command.options_of(kind.task):
            self._add(form, option)
        buttons = QDialogButtonBox(QDialogButtonBox.Ok | QDialogButtonBox.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form.addRow(buttons)

    def values(self) -> dict[str, Any]:
        """Return what was chosen, by names of options."""
        return {name: read() for name, read in self._read.items()}

    def _add(self, form: QFormLayout, option: dict[str, Any]) -> None:
        name, kind = option["name"], option["type"]
        title, about = command.title_of(option), command.about(option)
        if kind == "size":
            sides = [self._number(0, 262_144, 0) for _ in range(2)]
            for side, box in zip(("Width", "Height"), sides):  # noqa: B905, Python 3.8
                box.setSpecialValueText("default")
                box.setToolTip(about)
                form.addRow(side, box)
            self._read[name] = lambda: tuple(box.value() for box in sides)
            return
        if kind == "int":
            seed = name == "seed"
            field = self._number(
                0, 2**31 - 1 if seed else 8192, 1 if seed else option["default"] or 0
            )
            if not seed and option["default"] is None:
                field.setSpecialValueText("default")
            self._read[name] = field.value
        else:
            pairs, first = command.choices_of(option)
            field = QComboBox()
            for value, label in pairs:
                field.addItem(label, value)
            field.setCurrentIndex([value for value, _ in pairs].index(first))
            self._read[name] = field.currentData
        field.setToolTip(about)
        form.addRow(title, field)

    def _number(self, low: int, high: int, first: int) -> QSpinBox:
        field = QSpinBox()
        field.setRange(low, high)
        field.setValue(first)
        return field
