"""The entry point of Alembic: run the migrations in the connection and transaction of `hcsearch.store.migrate`."""

from alembic import context

from hcsearch.store.schema import VERSION_TABLE, metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    version_table=VERSION_TABLE,
    render_as_batch=True,  # SQLite alters a table by copying it
)
with context.begin_transaction():
    context.run_migrations()
