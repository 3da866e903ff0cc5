// The labels of masses: of the cells of a mass, all lead to the one that comes first, over cells with ever lower labels.
#define_import_path hachure::mass_labels

@group(0) @binding(1) var<storage, read_write> labels: array<atomic<u32>>;

// Returns the first cell to which the label of a cell leads.
fn first_of(cell: u32) -> u32 {
    var at = cell;
    var next = atomicLoad(&labels[at]);
    while next != at {
        at = next;
        next = atomicLoad(&labels[at]);
    }
    return at;
}
