"""What our panels share: they show for our engine only."""

ENGINE = 'STOKES'


def is_ours(context):
    return context.engine == ENGINE


class StokesPanel:
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return is_ours(context)


class RenderPanel(StokesPanel):
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    bl_context = "render"


def column_of(layout):
    """The two columns of names and values that all of Blender's own panels have."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout.column()
