"""A bpy image as an `image` message: its pixels as floats, with the name of their colour space."""

from array import array
from operator import mul

from ..core.stream import Blob


_ALPHA_DEPTHS = {32, 64, 128}  # bits per pixel of four channels


def is_sheer(image):
    """Whether Cycles multiplies its colours by alpha, which it undoes only where a node's alpha is
    used."""
    has_alpha = image.channels == 4 and image.depth in _ALPHA_DEPTHS
    return (
        has_alpha
        and image.alpha_mode in {'STRAIGHT', 'PREMUL'}
        and not image.colorspace_settings.is_data
    )


def is_there(image, context):
    """Whether it has pixels; a warning says why not, and what of it is left out."""
    if image.source == 'TILED':
        context.warn(image, "source", "of a tiled (UDIM) image only the first tile is used")
    if image.source in {'SEQUENCE', 'MOVIE'}:
        context.warn(image, "source", "only one frame of it is used, the one that is loaded")
    if min(image.size) and image.channels:  # asking for the size loads the file
        return True
    context.warn(image, "filepath", "has no pixels: %s" % (image.filepath or "no file"))
    return False


def send(image, name, context, times_alpha=False):
    """True if the image has been sent; else a warning has said why not."""
    if not is_there(image, context):
        return False
    width, height = image.size
    channels = image.channels
    pixels = array("f", bytes(4 * width * height * channels))
    image.pixels.foreach_get(pixels)
    if channels == 2:
        pixels, channels = _grey_alpha_to_rgba(pixels), 4
    if channels == 4:
        _apply_alpha_mode(image, pixels, times_alpha)
    context.send(
        "image",
        name=name,
        width=width,
        height=height,
        channels=channels,
        format="f32",
        colorspace=colorspace(image),
        pixels=Blob(pixels),
    )
    return True


def colorspace(image):
    """OpenColorIO name of the pixels' space. A float image is already in the working space: Blender
    converts it when the file is read; bytes it hands out as they are stored."""
    settings = image.colorspace_settings
    if settings.is_data:
        return "data"
    return "" if image.is_float else settings.name


def _grey_alpha_to_rgba(pixels):
    wide = array("f", bytes(8 * len(pixels)))
    for channel in range(3):
        wide[channel::4] = pixels[0::2]
    wide[3::4] = pixels[1::2]
    return wide


def _apply_alpha_mode(image, pixels, times_alpha):
    """Colour and alpha as Cycles' two outputs give them: alpha 1 where it is not asked for, and
    colours multiplied by it or not. Blender's float images are multiplied, those of bytes not;
    and Cycles multiplies bytes as they are stored, before they are decoded."""
    if image.alpha_mode == 'NONE':
        pixels[3::4] = array("f", [1.0]) * (len(pixels) // 4)
    elif times_alpha:
        if not image.is_float:
            _multiply_by_alpha(pixels)
    elif image.is_float and image.alpha_mode != 'CHANNEL_PACKED':
        _divide_by_alpha(pixels)


def _multiply_by_alpha(pixels):
    alphas = pixels[3::4]
    if min(alphas) >= 1.0:
        return
    for channel in range(3):
        pixels[channel::4] = array("f", map(mul, pixels[channel::4], alphas))


def _divide_by_alpha(pixels):
    alphas = pixels[3::4]
    if min(alphas) >= 1.0:
        return
    for texel, alpha in enumerate(alphas):
        if 0.0 < alpha < 1.0:
            at = 4 * texel
            pixels[at] /= alpha
            pixels[at + 1] /= alpha
            pixels[at + 2] /= alpha
