"""How a rig becomes one for images of another size."""


def fitted_to(own: tuple[int, int], wanted: tuple[int, int]) -> str:
    """What to do with a rig for images of one size where the images have another, as an advice: images of the same
    ratio of width to height are resampled, others are cut out."""
    (wide, high), (width, height) = own, wanted
    if abs(wide * height - width * high) < max(wide, high):  # sizes are whole pixels
        return f"resize the rig in Python: rig.resized(({width}, {height}))"
    scale = max(width / wide, height / high)
    if scale > 1.0:
        return "calibrate for these images, which are larger, and of another ratio of width to height"
    advice = f"crop the rig in Python: rig.cropped(({width}, {height})) if the images are cut out of the middle"
    if scale < 1.0:
        whole = round(wide * scale), round(high * scale)
        advice += f", rig.resized({whole}).cropped(({width}, {height})) if they are resampled, too"
    return advice
