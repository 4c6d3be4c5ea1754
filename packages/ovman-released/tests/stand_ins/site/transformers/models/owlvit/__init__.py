"""OWL-ViT's head, as its present release calls it."""


class OwlViTForObjectDetection:
    @staticmethod
    def normalize_grid_corner_coordinates(height, width):
        return height, width

    def boxes(self):
        return self.normalize_grid_corner_coordinates(24, 24)
