"""Deployment ratio and hinges of designs, which the views work out: no table changes."""

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Leave the tables as they are."""
