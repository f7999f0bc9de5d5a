"""Systems with frictional interfaces: statics and time integration; knows no finite elements."""
