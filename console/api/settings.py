"""The common settings, from their declarations; changes are saved in the settings file."""

from typing import Annotated

from fastapi import Path

from console.access.roles import needs
from console.api import HistoryInUse, Operator, RequestBody, part, router
from console.control.settings_in_use import ChangedSetting, SettingsInUse, SettingsState

settings = router("settings", 409, 507)
CommonSettings = Annotated[SettingsInUse, part(SettingsInUse)]

Word = Annotated[str, Path(max_length=40)]


class SettingRequest(RequestBody):
    """A new value of the setting's own type; null: its default."""

    value: bool | int | float | str | None


@settings.get("/settings")
@needs("viewer")
async def read(common: CommonSettings) -> SettingsState:
    """The common settings with unit, bounds and meaning, what holds now, and what holds from the next start on."""
    return common.state


@settings.put("/settings/{section}/{name}")
@needs("operator")
async def change(
    section: Word, name: Word, asked: SettingRequest, common: CommonSettings, history: HistoryInUse, who: Operator
) -> ChangedSetting:
    """Change one and save it; the sentence says whether it holds at once or from the next start on."""
    changed = await common.change(section, name, asked.value)
    history.add("setting", who, words=f"{section} {name}")
    return changed
